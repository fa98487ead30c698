"""The command `prp-gym tune-all`."""

import shlex
import sys
from collections.abc import Sequence
from contextlib import closing
from dataclasses import asdict
from typing import Annotated

import typer

from prp_gym.cli.compiler_note import note_missing_compiler
from prp_gym.cli.options import (
    Backend,
    Budget,
    ControllerNames,
    Engine,
    Environments,
    Json,
    ParallelWorkers,
    Plugins,
    Quiet,
    Resume,
    RunName,
    RunOutput,
    Seed,
    TableFormat,
)
from prp_gym.console.activity import Activity
from prp_gym.console.terminal import Terminal
from prp_gym.errors import InvalidValueError, PRPError
from prp_gym.evaluation.rollout import engine_suffix
from prp_gym.processes.interruption import kept_if_interrupted
from prp_gym.runs.result_folder import ResultFolder
from prp_gym.runs.search import Search
from prp_gym.runs.search_plan import list_combinations, plan_search, run_or_fail
from prp_gym.runs.selection import check_names
from prp_gym.runs.workers import Workers
from prp_gym.tables import Cell, ResultTable, TableColumn
from prp_gym.tables.column import prose_column, text_column
from prp_gym.tables.formats import TERMINAL
from prp_gym.tasks.registration import list_envs
from prp_gym.tasks.setup import MUJOCO
from prp_gym.tuning.tuned_controller import TunedController

_FAILED = 1  # exit code
_NOTE = (
    "score: mean over scenarios and validation episodes of the mean reward, 1 is perfect. A result that is "
    "the start was not surpassed. Edges: parameters whose best factor lies at the end of its range."
)


def tune_all_command(
    env: Environments = None,
    baseline: ControllerNames = None,
    budget: Budget = None,
    budget_scale: Annotated[
        float,
        typer.Option(help="Share of the budgets that is spent."),
    ] = 1.0,
    seed: Seed = 0,
    engine: Engine = MUJOCO,
    output: RunOutput = None,
    name: RunName = "",
    form: TableFormat = TERMINAL,
    jobs: ParallelWorkers = 0,
    backend: Backend = "loky",
    resume: Resume = True,
    quiet: Quiet = False,
    as_json: Json = False,
    plugin: Plugins = None,
) -> None:
    """Tune every controller on every environment for which it is intended; `ship-gains` ships the results.

    Each search maximises the mean over the scenarios realistic and randomized within a budget of simulated
    time, by default the simulated training time of an agent on the environment, and is validated as by
    `tune`, which also tunes a controller of your own. A run that was interrupted goes on where it stopped
    when the same command is given again.
    """
    workers = Workers(jobs, backend)
    if not 0.0 < budget_scale <= 100.0:
        raise InvalidValueError("--budget-scale", budget_scale, "above 0, at most 100")
    combinations = list_combinations(check_names("environment", env or [], list_envs()), baseline or [])
    command = shlex.join(["prp-gym", *sys.argv[1:]])
    content = [combinations, budget, budget_scale, seed, *([] if engine == MUJOCO else [engine])]
    folder = ResultFolder.choose("tune-all", output, name, content, goes_on=resume)
    searches = [
        plan_search(combination, budget, budget_scale, seed, folder.path, command, resume, engine)
        for combination in combinations
    ]
    searches.sort(key=lambda search: -search.task.budget)  # so that no worker is left alone with a long one
    terminal = Terminal.of(quiet, as_json, form)
    note_missing_compiler(terminal)
    with folder.in_use():  # one with a failed search stays unfinished, so that the same command tries again
        outcomes = _run(searches, workers, terminal)
        results = [outcome for outcome in outcomes if isinstance(outcome, TunedController)]
        failed = [str(outcome) for outcome in outcomes if isinstance(outcome, PRPError)]
        found = {"searches": [asdict(result) for result in results], "failed": failed}
        terminal.report(found, [_table(results)], [_NOTE], [f"results: {folder.path}"])
        if failed:
            raise typer.Exit(_FAILED)


def _run(
    searches: Sequence[Search], workers: Workers, terminal: Terminal
) -> list[TunedController | PRPError]:
    """What became of the searches, in the order in which they were finished."""
    waiting = [f"{search.task.environment_id} {search.task.controller}" for search in searches]
    outcomes: list[TunedController | PRPError] = []
    kept = f"the searches are kept in {searches[0].output}; the same command goes on there"
    with (
        kept_if_interrupted(lambda: kept),
        terminal.progress("tuning", len(searches), "searches") as progress,
        closing(workers.run(run_or_fail, searches)) as finished,
    ):
        progress.run([Activity(name) for name in waiting[: workers.count]])
        for index, outcome in finished:
            outcomes.append(outcome)
            task = searches[index].task
            name = f"{task.environment_id} {task.controller}"
            tell = terminal.warn if isinstance(outcome, PRPError) else terminal.note
            tell(f"{name}: {_line(outcome)}")
            waiting.remove(name)
            progress.advance(1)
            progress.run([Activity(name) for name in waiting[: workers.count]])
    return outcomes


def _line(outcome: TunedController | PRPError) -> str:
    """What became of a search, in a line."""
    if isinstance(outcome, PRPError):
        return f"failed: {outcome}"
    checked = outcome.validation
    return (
        f"{checked.score_of_start:.4f} -> {checked.score:.4f} after {outcome.trials} trials and "
        f"{outcome.seconds:.0f} s"
    )


def _table(results: Sequence[TunedController]) -> ResultTable:
    """A row for each result, by environment and controller."""
    columns = (
        *(text_column("environment"), text_column("controller"), TableColumn("score of the start")),
        *(TableColumn("score of the result"), TableColumn("gain"), TableColumn("trials")),
        *(TableColumn("time of the search", ("s",)), prose_column("edges")),
    )
    rows = [_row(item) for item in sorted(results, key=lambda item: (item.environment, item.controller))]
    title = f"validation of the searches{engine_suffix(item.engine for item in results)}"
    return ResultTable.of(title, columns, rows)


def _row(item: TunedController) -> tuple[Cell | str, ...]:
    checked = item.validation
    gain = checked.score - checked.score_of_start
    return (
        *(item.environment, item.controller),
        *(Cell.number(checked.score_of_start, ".4f"), Cell.number(checked.score, ".4f")),
        Cell("-", 0.0) if checked.kept_start else Cell.number(gain, "+.4f"),
        *(Cell.of(item.trials), Cell.number(item.seconds, ".0f")),
        "; ".join(f"{edge} ({reason})" for edge, reason in item.edges.items()),
    )
