"""The command `prp-gym tune`."""

import math
import shlex
import sys
from collections.abc import Sequence
from dataclasses import asdict
from fractions import Fraction
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

import prp_gym
from prp_gym.cli import completion
from prp_gym.cli.options import (
    Budget,
    ControlFrequency,
    Episodes,
    Json,
    OneController,
    OneEnvironment,
    Output,
    Plugins,
    Quiet,
    Resume,
    Scenarios,
    Seed,
    Settings,
    StartGains,
    only,
)
from prp_gym.console.activity import Activity
from prp_gym.console.terminal import Terminal
from prp_gym.errors import InvalidValueError
from prp_gym.runs.choice import TUNED, GainsChoice
from prp_gym.runs.controllers import Controllers
from prp_gym.runs.search import RESULT, Search
from prp_gym.runs.search_plan import EPISODES, SCENARIOS
from prp_gym.runs.selection import check_names
from prp_gym.runs.tuning_candidates import choose_controller, with_start_gains
from prp_gym.tasks.registration import list_envs
from prp_gym.tuning.task import TuningTask
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
    output: Output = Path("tuning"),
    resume: Resume = True,
    quiet: Quiet = False,
    as_json: Json = False,
    plugin: Plugins = None,
) -> None:
    """Tune a controller with a budget of simulated steps, and validate the result on fresh episodes.

    The mean over the scenarios is maximised, among which the episodes of a candidate are divided. The search
    starts from the gains `tuned`, or `tuned_50hz` where these are unstable. The ten best candidates are run
    on 20 fresh episodes, the best three of them on 100 more, together with the gains from which the search
    started; these are the result unless a candidate is better.
    """
    (environment_id,) = check_names("environment", [only("--env", env)], list_envs())
    steps = _budget(budget, like, control_frequency)
    name = _one_name(controller, baseline or [])
    choice, controllers = choose_controller(name, GainsChoice.read(gains or TUNED, settings or ()))
    if gains is None:
        choice = with_start_gains(choice, controllers, environment_id, control_frequency)
    task = TuningTask(environment_id, choice.name, tuple(scenario), control_frequency, steps, episodes, seed)
    search = Search(task, choice, output, shlex.join(["prp-gym", *sys.argv[1:]]), resume)
    terminal = Terminal(quiet, as_json)
    result = _run(search, controllers, terminal)
    terminal.document(asdict(result))
    _show(result, search.folder / RESULT, terminal)


def _one_name(controller: str | None, baseline: Sequence[str]) -> str:
    """The controller, named by the argument or by the option.

    Raises:
        InvalidValueError: named by none of the two, or by both.
    """
    given = [*([controller] if controller is not None else []), *baseline]
    if len(given) != 1:
        raise InvalidValueError("controller and --baseline", given, "exactly one name by the two together")
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


def _show(result: TunedController, target: Path, terminal: Terminal) -> None:
    """Print the scores before and after."""
    scenarios = " and ".join(result.scenarios)
    title = f"{result.controller} on {result.environment}, scenario {scenarios}"
    table = Table()
    checked = result.validation
    for header in ("settings", "training score", "validation score"):
        table.add_column(header, justify="left" if header == "settings" else "right")
    table.add_row("start", f"{result.score_of_start:.4f}", f"{checked.score_of_start:.4f}")
    table.add_row("result", f"{result.score:.4f}", f"{checked.score:.4f}")
    terminal.show(title, table)
    terminal.explain(
        f"score: mean over scenarios of the mean reward, over {result.episodes} training and "
        f"{checked.episodes} validation episodes; 1 is perfect."
    )
    if checked.kept_start:
        terminal.show("No candidate was better than the start on the validation episodes: it is the result.")
    for edge, reason in result.edges.items():
        terminal.show(f"The best candidate lies at an edge of {edge} end: {reason}.")
    terminal.explain(
        f"{result.trials} trials, {result.used_steps} of {result.budget_steps} steps"
        f" ({result.simulated_seconds:g} s simulated), {result.seconds:.1f} s."
    )
    terminal.show(f"result: {target}")
