"""The command `prp-gym tune`."""

import math
import shlex
import sys
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from fractions import Fraction
from pathlib import Path
from typing import Annotated

import typer

import prp_gym
from prp_gym.cli.options import Output, Plugins, RunName, Settings, TableFormat
from prp_gym.cli.shown import show_tables
from prp_gym.errors import InvalidValueError, UnknownNameError
from prp_gym.runs.choice import TUNED, GainsChoice
from prp_gym.runs.controllers import Controllers
from prp_gym.runs.result_folder import ResultFolder
from prp_gym.runs.search import RESULT, Search
from prp_gym.runs.search_plan import EPISODES, SCENARIOS
from prp_gym.runs.terminal import make_console, make_progress
from prp_gym.runs.tuning_candidates import choose_controller, with_start_gains
from prp_gym.tables import Cell, ResultTable, TableColumn
from prp_gym.tables.column import text_column
from prp_gym.tables.formats import TERMINAL
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
    output: Output = None,
    name: RunName = "",
    form: TableFormat = TERMINAL,
    resume: Annotated[
        bool, typer.Option("--resume", help="Go on with a search that was interrupted, if there is one.")
    ] = False,
    plugin: Plugins = None,
) -> None:
    """Tune a controller with a budget of simulated steps, and validate the result on fresh episodes.

    The ten best candidates are run on 20 fresh episodes, the best three of them on 100 more, together with
    the gains from which the search started; these are the result unless a candidate is better.
    """
    if env not in list_envs():
        raise UnknownNameError("environment", env, list_envs())
    steps = _budget(budget, like, control_frequency)
    chosen = _one_name(controller, baseline)
    choice, controllers = choose_controller(chosen, GainsChoice.read(gains or TUNED, settings or ()))
    if gains is None:
        choice = with_start_gains(choice, controllers, env, control_frequency)
    scenarios = tuple(scenario or SCENARIOS)
    task = TuningTask(env, choice.name, scenarios, control_frequency, steps, episodes, seed)
    content = [asdict(task), asdict(choice)]
    folder = ResultFolder.choose("tune", output, name, content, goes_on=resume)
    search = Search(task, choice, folder.path, shlex.join(["prp-gym", *sys.argv[1:]]), resume)
    with folder.in_use():
        result = _run(search, controllers)
    show_tables([_table(result)], _notes(result, search.folder / RESULT), form)


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


def _table(result: TunedController) -> ResultTable:
    """The scores before and after."""
    scenarios = " and ".join(result.scenarios)
    title = f"{result.controller} on {result.environment}, scenario {scenarios}"
    columns = (text_column("settings"), TableColumn("training score"), TableColumn("validation score"))
    scores = {
        "start": (result.score_of_start, result.validation.score_of_start),
        "result": (result.score, result.validation.score),
    }
    rows = [(Cell.of(name), *(Cell.number(score, ".4f") for score in own)) for name, own in scores.items()]
    return ResultTable.of(title, columns, rows)


def _notes(result: TunedController, target: Path) -> Iterator[str]:
    """What explains the scores, and where the result is."""
    checked = result.validation
    yield (
        f"score: mean over scenarios of the mean reward, over {result.episodes} training and "
        f"{checked.episodes} validation episodes; 1 is perfect."
    )
    if checked.kept_start:
        yield "No candidate was better than the start on the validation episodes: it is the result."
    for edge, reason in result.edges.items():
        yield f"The best candidate lies at an edge of {edge} end: {reason}."
    yield (
        f"{result.trials} trials, {result.used_steps} of {result.budget_steps} steps"
        f" ({result.simulated_seconds:g} s simulated), {result.seconds:.1f} s."
    )
    yield f"result: {target}"
