"""The command `prp-gym tune`."""

import math
import shlex
import sys
from contextlib import closing
from dataclasses import asdict
from fractions import Fraction
from importlib.metadata import version
from pathlib import Path
from typing import Annotated, Any

import gymnasium
import typer
from rich.table import Table

import prp_gym
from prp_gym.artifacts import list_versions, to_plain, write_json
from prp_gym.cli.options import Plugins, Settings
from prp_gym.errors import InvalidValueError, UnknownNameError
from prp_gym.evaluation.evaluate import episodes_to_run
from prp_gym.files.checksum import seal
from prp_gym.processes.folder_lock import FolderLock
from prp_gym.processes.interruption import kept_if_interrupted
from prp_gym.runs.choice import TUNED, ControllerChoice, GainsChoice
from prp_gym.runs.code import running_code
from prp_gym.runs.terminal import TABLE_WIDTH, make_console, make_progress
from prp_gym.runs.tuning_candidates import choose_controller, list_candidates, with_start_gains
from prp_gym.tasks.registration import list_envs
from prp_gym.tuning.candidates import Candidates
from prp_gym.tuning.episodes import Episodes
from prp_gym.tuning.stored_study import StoredStudy
from prp_gym.tuning.task import VALIDATION_SEED, TuningTask
from prp_gym.tuning.tune import Tuned, tune
from prp_gym.tuning.tuned_controller import TunedController, Validation

VALIDATION_EPISODES = 100
RESULT = "result.json"


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
    scenario: Annotated[str, typer.Option(help="Scenario.")] = "randomized",
    control_frequency: Annotated[float, typer.Option(help="Control frequency [Hz].")] = 500.0,
    episodes: Annotated[int, typer.Option(help="Training episodes of every candidate.")] = 20,
    seed: Annotated[int, typer.Option(help="Seed of the search and of its training episodes.")] = 0,
    gains: StartGains = None,
    settings: Settings = None,
    output: Annotated[Path, typer.Option(help="Folder for the folder of the search.")] = Path("tuning"),
    resume: Annotated[
        bool, typer.Option("--resume", help="Go on with a search that was interrupted, if there is one.")
    ] = False,
    plugin: Plugins = None,
) -> None:
    """Tune a controller with a budget of simulated steps, and compare it with the gains that it had."""
    if env not in list_envs():
        raise UnknownNameError("environment", env, list_envs())
    steps = _budget(budget, like, control_frequency)
    name = _one_name(controller, baseline)
    choice, controllers = choose_controller(name, GainsChoice.read(gains or TUNED, settings or ()))
    if gains is None:
        choice = with_start_gains(choice, controllers, env, control_frequency)
    task = TuningTask(env, choice.name, scenario, control_frequency, steps, episodes, seed)
    folder = output / f"{env}_{choice.file_name}"
    with (
        closing(gymnasium.make(env, scenario=scenario, control_frequency=control_frequency)) as made,
        FolderLock(folder).hold(),
    ):
        candidates = list_candidates(choice, controllers, made)
        study = StoredStudy(folder, candidates.space, _key(task, choice), seed, resume)
        with controllers.reported(choice, made), kept_if_interrupted(lambda: _kept(study, folder)):
            tuned = _search(task, made, candidates, study)
            checked = _validate(made, candidates, tuned)
        result = _result(task, choice, tuned, episodes_to_run(made, task.episodes), checked)
        write_json(folder / RESULT, seal(asdict(result)))
    _show(result, folder / RESULT)


def _kept(study: StoredStudy, folder: Path) -> str:
    """What an interrupted search has kept."""
    steps = sum(trial.steps for trial in study.trials)
    return f"{steps} steps of the budget are kept in {folder}; the same command with --resume goes on there"


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


def _key(task: TuningTask, choice: ControllerChoice) -> dict[str, Any]:
    """Everything that the trials of a search depend on."""
    code = {**running_code(), "optuna": version("optuna")}
    plain: dict[str, Any] = to_plain({**asdict(task), "start": asdict(choice), "code": code})
    return plain


def _search(
    task: TuningTask, env: gymnasium.Env[Any, Any], candidates: Candidates, study: StoredStudy
) -> Tuned:
    """Spend the budget behind a progress bar."""
    before = sum(trial.steps for trial in study.trials)
    if before:
        note = f"{len(study.trials)} trials with {before} steps were finished by an interrupted run."
        make_console(stderr=True).print(note, highlight=False)
    with make_progress() as progress:
        bar = progress.add_task(f"tuning {task.controller} [steps]", total=task.budget, completed=before)
        return tune(task, env, candidates, study, lambda trial: progress.advance(bar, trial.steps))


def _validate(env: gymnasium.Env[Any, Any], candidates: Candidates, tuned: Tuned) -> Validation:
    """The best settings and the first ones on episodes that the search did not use."""
    count = episodes_to_run(env, VALIDATION_EPISODES)
    episodes = Episodes(env, range(VALIDATION_SEED, VALIDATION_SEED + count))
    found, start = (
        float(episodes.run(candidates.make(factors)).scores.mean())
        for factors in (tuned.best.factors, candidates.space.start)
    )
    return Validation(seed=VALIDATION_SEED, episodes=count, score=found, score_of_tuned=start)


def _result(
    task: TuningTask, choice: ControllerChoice, tuned: Tuned, episodes: int, validation: Validation
) -> TunedController:
    return TunedController(
        environment=task.environment_id,
        controller=task.controller,
        scenario=task.scenario,
        control_frequency=float(task.control_frequency),
        settings=tuned.settings,
        budget_steps=task.budget,
        used_steps=tuned.used_steps,
        simulated_seconds=tuned.used_steps / task.control_frequency,
        trials=len(tuned.trials),
        episodes=episodes,
        seconds=sum(trial.seconds for trial in tuned.trials),
        history=tuple(tuned.history),
        score=tuned.best.score,
        score_of_tuned=tuned.trials[0].score,
        validation=validation,
        seed=task.seed,
        command=shlex.join(["prp-gym", *sys.argv[1:]]),
        versions={**list_versions(), "optuna": version("optuna")},
        code=choice.facts.get("code", {}),
    )


def _show(result: TunedController, target: Path) -> None:
    """Print the scores before and after."""
    title = f"{result.controller} on {result.environment}, scenario {result.scenario}"
    table = Table()
    checked = result.validation
    for header in ("settings", "training score", "validation score"):
        table.add_column(header, justify="left" if header == "settings" else "right")
    table.add_row("tuned", f"{result.score_of_tuned:.4f}", f"{checked.score_of_tuned:.4f}")
    table.add_row("equal budget", f"{result.score:.4f}", f"{checked.score:.4f}")
    console = make_console(least=TABLE_WIDTH)
    console.print(title, highlight=False)
    console.print(table)
    console.print(
        f"score: mean reward, over {result.episodes} training and {checked.episodes} validation"
        " episodes; 1 is perfect."
    )
    console.print(
        f"{result.trials} trials, {result.used_steps} of {result.budget_steps} steps"
        f" ({result.simulated_seconds:g} s simulated), {result.seconds:.1f} s."
    )
    console.print(f"result: {target}", highlight=False)
