"""The command `prp-gym tune`."""

import math
import shlex
import sys
from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

import prp_gym
from prp_gym.cli.options import Plugins, Settings
from prp_gym.errors import InvalidValueError, UnknownNameError
from prp_gym.runs.choice import TUNED, GainsChoice
from prp_gym.runs.controllers import Controllers
from prp_gym.runs.search import RESULT, Search
from prp_gym.runs.search_plan import EPISODES, SCENARIOS
from prp_gym.runs.terminal import TABLE_WIDTH, make_console, make_progress
from prp_gym.runs.tuning_candidates import choose_controller, with_start_gains
from prp_gym.tasks.registration import list_envs
from prp_gym.tuning.task import TuningTask
from prp_gym.tuning.trial import Trial
from prp_gym.tuning.tuned_controller import TunedController

ControllerArgument = Annotated[
    str | None,
    typer.Argument(help="Controller to tune, or your own as path/to/file.py:Name or package.module:Name."),
]
ControllerOption = Annotated[
    str | None, typer.Option("--baseline", help="Controller to tune, as an option in place of the argument.")
]
StartGains = Annotated[
    str | None,
    typer.Option(
        help="Gains from which the search starts: the name of a gain set, or a TOML file of settings. "
        "Default: tuned, or tuned_50hz where that is unstable."
    ),
]


def tune_command(
    env: Annotated[str, typer.Option(help="Environment id.")],
    controller: ControllerArgument = None,
    baseline: ControllerOption = None,
    budget: Annotated[
        int | None, typer.Option(help="Control steps to simulate at most, of all environments together.")
    ] = None,
    like: Annotated[
        str | None,
        typer.Option(
            help="In place of --budget: an agent, name or path, whose simulated time is the budget."
        ),
    ] = None,
    scenario: Annotated[
        list[str] | None,
        typer.Option(
            help="Scenario; repeatable. The mean over them is maximised. Default: realistic and randomized."
        ),
    ] = None,
    control_frequency: Annotated[float, typer.Option(help="Control frequency [Hz].")] = 500.0,
    episodes: Annotated[
        int, typer.Option(help="Training episodes of every candidate, divided evenly among the scenarios.")
    ] = EPISODES,
    seed: Annotated[int, typer.Option(help="Seed of the search and of its training episodes.")] = 0,
    gains: StartGains = None,
    settings: Settings = None,
    output: Annotated[Path, typer.Option(help="Folder for the folder of the search.")] = Path("tuning"),
    resume: Annotated[
        bool, typer.Option("--resume", help="Go on with a search that was interrupted, if there is one.")
    ] = False,
    plugin: Plugins = None,
) -> None:
    """Tune a controller with a budget of simulated steps, and validate the result on fresh episodes.

    The ten best candidates are run on 20 fresh episodes, the best three of them on 100 more, together with
    the gains from which the search started; these are the result unless a candidate is better by more than
    twice the standard error of the difference.
    """
    if env not in list_envs():
        raise UnknownNameError("environment", env, list_envs())
    steps = _budget(budget, like, control_frequency)
    name = _one_name(controller, baseline)
    choice, controllers = choose_controller(name, GainsChoice.read(gains or TUNED, settings or ()))
    if gains is None:
        choice = with_start_gains(choice, controllers, env, control_frequency)
    scenarios = tuple(scenario or SCENARIOS)
    task = TuningTask(env, choice.name, scenarios, control_frequency, steps, episodes, seed)
    search = Search(task, choice, output, shlex.join(["prp-gym", *sys.argv[1:]]), resume)
    _show(_run(search, controllers), search.folder / RESULT)


def _one_name(controller: str | None, baseline: str | None) -> str:
    """The controller, named by the argument or by the option.

    Raises:
        InvalidValueError: named by none of the two, or by both.
    """
    given = [name for name in (controller, baseline) if name is not None]
    if len(given) != 1:
        raise InvalidValueError("controller and --baseline", (controller, baseline), "exactly one of the two")
    return given[0]


def _budget(budget: int | None, like: str | None, control_frequency: float) -> int:
    """The budget given, or the steps of a controller in the simulated training time of an agent.

    Raises:
        InvalidValueError: none of the two, or both.
    """
    if (budget is None) == (like is None):
        raise InvalidValueError("--budget and --like", (budget, like), "exactly one of the two")
    if budget is not None:
        return budget
    card = prp_gym.load_agent(str(like)).card
    # as fractions, so that no step is lost to rounding
    return math.floor(Fraction(card.steps) * Fraction(control_frequency) / Fraction(card.control_frequency))


def _run(search: Search, controllers: Controllers) -> TunedController:
    """Run a search behind a progress bar."""
    task = search.task
    with make_progress() as progress:
        bar = progress.add_task(f"tuning {task.controller} [steps]", total=task.budget)

        def started(trials: Sequence[Trial]) -> None:
            before = sum(trial.steps for trial in trials)
            progress.advance(bar, before)
            if before:
                note = f"{len(trials)} trials with {before} steps were finished by an interrupted run."
                make_console(stderr=True).print(note, highlight=False)

        return search.run(controllers, started, lambda trial: progress.advance(bar, trial.steps))


def _show(result: TunedController, target: Path) -> None:
    """Print the scores before and after."""
    scenarios = " and ".join(result.scenarios)
    title = f"{result.controller} on {result.environment}, scenario {scenarios}"
    table = Table()
    checked = result.validation
    for header in ("settings", "training score", "validation score"):
        table.add_column(header, justify="left" if header == "settings" else "right")
    table.add_row("start", f"{result.score_of_start:.4f}", f"{checked.score_of_start:.4f}")
    table.add_row("result", f"{result.score:.4f}", f"{checked.score:.4f}")
    console = make_console(least=TABLE_WIDTH)
    console.print(title, highlight=False)
    console.print(table)
    console.print(
        f"score: mean over scenarios of the mean reward, over {result.episodes} training and "
        f"{checked.episodes} validation episodes; 1 is perfect."
    )
    if checked.kept_start:
        console.print(
            "No candidate was better than the start by more than chance on the validation episodes: the "
            "start is the result."
        )
    for edge, reason in result.edges.items():
        console.print(f"The best candidate lies at an edge of {edge} end: {reason}.", highlight=False)
    console.print(
        f"{result.trials} trials, {result.used_steps} of {result.budget_steps} steps"
        f" ({result.simulated_seconds:g} s simulated), {result.seconds:.1f} s."
    )
    console.print(f"result: {target}", highlight=False)
