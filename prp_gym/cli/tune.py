"""The command `prp-gym tune`."""

import math
import shlex
import sys
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from fractions import Fraction
from typing import Annotated

import typer

import prp_gym
from prp_gym.cli import completion
from prp_gym.cli.compiler_note import note_missing_compiler
from prp_gym.cli.one_policy import name_by_argument
from prp_gym.cli.options import (
    Budget,
    ControlFrequency,
    Engine,
    Episodes,
    Json,
    OneController,
    OneEnvironment,
    Plugins,
    Quiet,
    Resume,
    RunName,
    RunOutput,
    Scenarios,
    Seed,
    Settings,
    StartGains,
    TableFormat,
    only,
)
from prp_gym.console.activity import Activity
from prp_gym.console.terminal import Terminal
from prp_gym.errors import InvalidValueError
from prp_gym.evaluation.rollout import condition_name
from prp_gym.runs.choice import TUNED, GainsChoice
from prp_gym.runs.controllers import Controllers
from prp_gym.runs.key import key_of
from prp_gym.runs.result_folder import ResultFolder
from prp_gym.runs.search import RESULT, Search
from prp_gym.runs.search_plan import SCENARIOS
from prp_gym.runs.selection import check_names
from prp_gym.runs.tuning_candidates import choose_controller, with_start_gains
from prp_gym.tables import Cell, ResultTable, TableColumn
from prp_gym.tables.column import text_column
from prp_gym.tables.formats import TERMINAL
from prp_gym.tasks.registration import list_envs
from prp_gym.tasks.setup import MUJOCO
from prp_gym.tuning.task import EPISODES, FINAL_EPISODES, METHODS, SAMPLING, TuningTask
from prp_gym.tuning.trial import Trial
from prp_gym.tuning.tuned_controller import TunedController

_DEFAULT_SCENARIOS = list(SCENARIOS)

ControllerArgument = Annotated[
    str | None,
    typer.Argument(help="Controller to tune, in place of --baseline.", autocompletion=completion.controllers),
]
Like = Annotated[
    str | None,
    typer.Option(
        help="In place of --budget: an agent, name or path, whose simulated time is the budget.",
        autocompletion=completion.agents,
    ),
]
Method = Annotated[
    str,
    typer.Option(
        help=f"How candidates are found: {', '.join(METHODS)}. The second follows the exact derivatives of "
        "the score by all settings, in compiled code; it needs a C compiler.",
        autocompletion=completion.methods,
    ),
]
FinalEpisodes = Annotated[
    int,
    typer.Option(help="Fresh episodes that compare the best three candidates with the start of the search."),
]


def tune_command(
    env: OneEnvironment,
    controller: ControllerArgument = None,
    baseline: OneController = None,
    budget: Budget = None,
    like: Like = None,
    scenario: Scenarios = _DEFAULT_SCENARIOS,
    control_frequency: ControlFrequency = 500.0,
    episodes: Episodes = EPISODES,
    seed: Seed = 0,
    gains: StartGains = None,
    settings: Settings = None,
    engine: Engine = MUJOCO,
    method: Method = SAMPLING,
    final_episodes: FinalEpisodes = FINAL_EPISODES,
    output: RunOutput = None,
    name: RunName = "",
    form: TableFormat = TERMINAL,
    resume: Resume = True,
    quiet: Quiet = False,
    as_json: Json = False,
    plugin: Plugins = None,
) -> None:
    """Tune a controller with a budget of simulated steps, and validate the result on fresh episodes.

    The mean over the scenarios is maximised, among which the episodes of a candidate are divided. The search
    starts from the gains `tuned`, or `tuned_50hz` where these are unstable. The ten best candidates are run
    on 20 fresh episodes, the best three of them on more (--final-episodes), together with the gains from
    which the search started; these are the result unless a candidate is better by more than twice the
    standard error of the difference.
    """
    (environment_id,) = check_names("environment", [only("--env", env)], list_envs())
    steps = _budget(budget, like, control_frequency)
    chosen = name_by_argument(controller, baseline or [])
    choice, controllers = choose_controller(chosen, GainsChoice.read(gains or TUNED, settings or ()))
    if gains is None:
        choice = with_start_gains(choice, controllers, environment_id, control_frequency)
    task = TuningTask(
        *(environment_id, choice.name, tuple(scenario), control_frequency, steps, episodes),
        *(seed, engine, method, final_episodes),
    )
    terminal = Terminal.of(quiet, as_json, form)
    note_missing_compiler(terminal)
    folder = ResultFolder.choose("tune", output, name, [key_of(task), asdict(choice)], goes_on=resume)
    search = Search(task, choice, folder.path, shlex.join(["prp-gym", *sys.argv[1:]]), resume)
    with folder.in_use():
        result = _run(search, controllers, terminal)
    lines = [*_findings(result), f"result: {search.folder / RESULT}"]
    terminal.report(asdict(result), [_table(result)], _notes(result), lines)


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


def _run(search: Search, controllers: Controllers, terminal: Terminal) -> TunedController:
    """Run a search, and tell its progress."""
    task = search.task
    with terminal.progress(f"tuning {task.controller}", task.budget, "steps") as progress:

        def started(trials: Sequence[Trial]) -> None:
            before = sum(trial.steps for trial in trials)
            progress.begin(before)
            if before:
                note = f"{len(trials)} trials with {before} steps were finished by an interrupted run."
                terminal.note(note)

        return search.run(
            controllers,
            started,
            lambda trial: progress.advance(trial.steps),
            lambda: progress.run([Activity("validation of the best candidates")]),
        )


def _table(result: TunedController) -> ResultTable:
    """The scores before and after."""
    condition = condition_name(result.environment, " and ".join(result.scenarios), result.engine)
    title = f"{result.controller} on {condition}"
    columns = (text_column("settings"), TableColumn("training score"), TableColumn("validation score"))
    scores = {
        "start": (result.score_of_start, result.validation.score_of_start),
        "result": (result.score, result.validation.score),
    }
    rows = [(Cell.of(name), *(Cell.number(score, ".4f") for score in own)) for name, own in scores.items()]
    return ResultTable.of(title, columns, rows)


def _notes(result: TunedController) -> Iterator[str]:
    """What explains the scores."""
    yield (
        f"score: mean over scenarios of the mean reward, over {result.episodes} training and "
        f"{result.validation.episodes} validation episodes; 1 is perfect."
    )
    yield (
        f"{result.trials} trials, {result.used_steps} of {result.budget_steps} steps"
        f" ({result.simulated_seconds:g} s simulated), {result.seconds:.1f} s."
    )


def _findings(result: TunedController) -> Iterator[str]:
    """What the search found beside the scores."""
    if result.validation.kept_start:
        yield (
            "No candidate was better than the start by more than chance on the validation episodes: the "
            "start is the result."
        )
    for edge, reason in result.edges.items():
        yield f"The best candidate lies at an edge of {edge} end: {reason}."
