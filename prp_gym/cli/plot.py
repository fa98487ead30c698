"""The command `prp-gym plot`."""

from pathlib import Path
from typing import Annotated

import typer

from prp_gym.checks import choice
from prp_gym.cli.options import FirstSeed, Gains, Plugins, RunName, Settings
from prp_gym.errors import InvalidValueError
from prp_gym.evaluation.rollout import Rollout
from prp_gym.figures.figure_file import SUFFIXES, check_suffix, write_figure
from prp_gym.runs.choice import TUNED, GainsChoice
from prp_gym.runs.result_folder import ResultFolder
from prp_gym.runs.single_run import SingleRun
from prp_gym.runs.terminal import make_console
from prp_gym.tasks.registration import list_envs

_FIGURE = "figure.png"


def plot_command(
    context: typer.Context,
    env: Annotated[str, typer.Argument(help="Environment id.")],
    baseline: Annotated[
        str,
        typer.Option(
            help="Controller, or your own as path/to/file.py:Name or package.module:Name. Default: the first "
            "that is meant for the environment."
        ),
    ] = "",
    agent: Annotated[
        str, typer.Option(help="In place of a controller: an agent, by its name or the path of its files.")
    ] = "",
    scenario: Annotated[str, typer.Option(help="Scenario.")] = "realistic",
    seed: FirstSeed = 0,
    gains: Gains = TUNED,
    settings: Settings = None,
    control_frequency: Annotated[float, typer.Option(help="Control frequency [Hz].")] = 500.0,
    output: Annotated[
        Path | None,
        typer.Option(
            help=f"File of the figure, {', '.join(SUFFIXES)} by its suffix. Default: "
            f"results/plot/<date and time>/{_FIGURE}."
        ),
    ] = None,
    name: RunName = "",
    plugin: Plugins = None,
) -> None:
    """Run one episode and draw it: motion, errors, torques with their limits, contact force and reward."""
    run = SingleRun(choice("environment", env, list_envs()), scenario, seed)
    _check_choice(context, baseline, agent)
    if output is not None:
        check_suffix(output)
    rollout, policy = (
        run.of_agent(agent)
        if agent
        else run.of_controller(baseline, GainsChoice.read(gains, settings or ()), control_frequency)
    )
    target = _write(rollout, policy, output, name)
    make_console().print(f"figure: {target}", highlight=False, markup=False, soft_wrap=True)


def _check_choice(context: typer.Context, baseline: str, agent: str) -> None:
    """Refuse options of a controller beside an agent.

    Raises:
        InvalidValueError: such an option.
    """
    if not agent:
        return
    if baseline:
        raise InvalidValueError("--baseline and --agent", (baseline, agent), "one of the two")
    for name, option in (
        ("gains", "--gains"),
        ("settings", "--set"),
        ("control_frequency", "--control-frequency"),
    ):
        source = context.get_parameter_source(name)
        if source is not None and source.name == "COMMANDLINE":
            raise InvalidValueError(option, context.params[name], "not with --agent, which has its own")


def _write(rollout: Rollout, policy: str, output: Path | None, name: str) -> Path:
    """Write the figure, into a folder of its own unless a file is named."""
    figure = rollout.plot(policy)
    folder = ResultFolder.choose("plot", None if output is None else output.parent, name, [], goes_on=False)
    target = folder.path / _FIGURE if output is None else output
    with folder.in_use():
        write_figure(target, figure)
    return target
