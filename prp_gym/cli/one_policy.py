"""The one policy of a command: a controller or an agent."""

from collections.abc import Sequence
from pathlib import Path

import typer

from prp_gym.checks import choice
from prp_gym.cli.options import at_most_one, only
from prp_gym.errors import InvalidValueError
from prp_gym.runs.first_controller import first_controller
from prp_gym.tasks.scenario import SCENARIOS

_OPTIONS = {"gains": "--gains", "settings": "--set", "control_frequency": "--control-frequency"}


def name_controller(
    context: typer.Context, env: str, baseline: Sequence[str] | None, agent: Sequence[Path] | None
) -> str | None:
    """The controller that options name, or the first one of the environment; None beside an agent.

    Args:
        context: command with its options.
        env: environment id.
        baseline: values of `--baseline`.
        agent: values of `--agent`.

    Raises:
        InvalidValueError: a controller and an agent, several of them, or gains beside an agent.
    """
    controller = at_most_one("--baseline", baseline)
    chosen = name_agent(agent)
    if chosen is None:
        return controller or first_controller(env)
    if controller is not None:
        raise InvalidValueError("--baseline and --agent", (controller, chosen), "one of the two")
    refuse(context, ("gains", "settings"))
    return None


def name_by_argument(controller: str | None, baseline: Sequence[str]) -> str:
    """The controller of a command, named by its argument or by the option.

    Args:
        controller: argument of the command.
        baseline: values of `--baseline`.

    Raises:
        InvalidValueError: named by none of the two, or by both.
    """
    given = [*([controller] if controller is not None else []), *baseline]
    if len(given) != 1:
        raise InvalidValueError("controller and --baseline", given, "exactly one name by the two together")
    return given[0]


def name_agent(agent: Sequence[Path] | None) -> str | None:
    """The agent that options name, by its name or the path of its files.

    Args:
        agent: values of `--agent`.

    Raises:
        InvalidValueError: several agents.
    """
    return at_most_one("--agent", [path.as_posix() for path in agent or ()])


def name_scenario(scenario: Sequence[str]) -> str:
    """The scenario that options name.

    Args:
        scenario: values of `--scenario`.

    Raises:
        InvalidValueError: several scenarios.
        UnknownNameError: a scenario that does not exist.
    """
    return choice("scenario", only("--scenario", scenario), list(SCENARIOS))


def refuse(context: typer.Context, names: Sequence[str]) -> None:
    """Refuse options of controllers where an agent runs, which brings its own.

    Args:
        context: command with its options.
        names: parameters of the options.

    Raises:
        InvalidValueError: one of them stands on the command line.
    """
    for name in names:
        source = context.get_parameter_source(name)
        if source is not None and source.name == "COMMANDLINE":
            raise InvalidValueError(
                _OPTIONS[name], context.params[name], "not with --agent, which has its own"
            )
