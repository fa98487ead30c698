"""The command `prp-gym tune-all`."""

import shlex
import sys
from collections.abc import Sequence
from contextlib import closing
from typing import Annotated

import typer

from prp_gym.cli.options import (
    Backend,
    Environments,
    Output,
    ParallelWorkers,
    Plugins,
    RunName,
    TableFormat,
)
from prp_gym.cli.shown import show_tables
from prp_gym.errors import InvalidValueError, PRPError
from prp_gym.processes.interruption import kept_if_interrupted
from prp_gym.runs.result_folder import ResultFolder
from prp_gym.runs.search import Search
from prp_gym.runs.search_plan import list_combinations, plan_search, run_or_fail
from prp_gym.runs.selection import check_names
from prp_gym.runs.terminal import make_console, make_progress
from prp_gym.runs.workers import Workers
from prp_gym.tables import Cell, ResultTable, TableColumn
from prp_gym.tables.column import prose_column, text_column
from prp_gym.tables.formats import TERMINAL
from prp_gym.tasks.registration import list_envs
from prp_gym.tuning.tuned_controller import TunedController

_FAILED = 1  # exit code
_NOTE = (
    "score: mean over scenarios and validation episodes of the mean reward, 1 is perfect. A result that is "
    "the start was not surpassed. Edges: parameters whose best factor lies at the end of its range."
)


def tune_all_command(
    env: Environments = None,
    baseline: Annotated[list[str] | None, typer.Option(help="Controller; repeatable. Default: all.")] = None,
    budget: Annotated[
        int | None,
        typer.Option(
            help="Control steps to simulate at most in each search, of all environments together. Default: "
            "the simulated training time of an agent on the environment."
        ),
    ] = None,
    budget_scale: Annotated[
        float,
        typer.Option(help="Share of these budgets that is spent."),
    ] = 1.0,
    seed: Annotated[int, typer.Option(help="Seed of the searches and of their training episodes.")] = 0,
    output: Output = None,
    name: RunName = "",
    form: TableFormat = TERMINAL,
    jobs: ParallelWorkers = 0,
    backend: Backend = "loky",
    plugin: Plugins = None,
) -> None:
    """Tune every controller on every environment for which it is intended; `ship-gains` ships the results.

    Each search maximises the mean over the scenarios realistic and randomized within a budget of simulated
    time, and is validated as by `tune`. A run that was interrupted goes on where it stopped when the same
    command is given again.
    """
    workers = Workers(jobs, backend)
    if not 0.0 < budget_scale <= 100.0:
        raise InvalidValueError("--budget-scale", budget_scale, "above 0, at most 100")
    combinations = list_combinations(check_names("environment", env or [], list_envs()), baseline or [])
    command = shlex.join(["prp-gym", *sys.argv[1:]])
    content = [combinations, budget, budget_scale, seed]
    folder = ResultFolder.choose("tune-all", output, name, content, goes_on=True)
    searches = [
        plan_search(combination, budget, budget_scale, seed, folder.path, command)
        for combination in combinations
    ]
    searches.sort(key=lambda search: -search.task.budget)  # so that no worker is left alone with a long one
    with folder.in_use():  # one with a failed search stays unfinished, so that the same command tries again
        outcomes = _run(searches, workers, form)
        results = [outcome for outcome in outcomes if isinstance(outcome, TunedController)]
        show_tables([_table(results)], (_NOTE, f"results: {folder.path}"), form)
        if len(results) < len(searches):
            raise typer.Exit(_FAILED)


def _run(searches: Sequence[Search], workers: Workers, form: str) -> list[TunedController | PRPError]:
    """Run the searches behind a progress bar, and print a line for each that ends."""
    console = make_console(stderr=form != TERMINAL)
    outcomes: list[TunedController | PRPError] = []
    kept = f"the searches are kept in {searches[0].output}; the same command goes on there"
    with (
        kept_if_interrupted(lambda: kept),
        make_progress() as progress,
        closing(workers.run(run_or_fail, searches)) as finished,
    ):
        bar = progress.add_task("searches", total=len(searches))
        for index, outcome in finished:
            outcomes.append(outcome)
            task = searches[index].task
            console.print(f"{task.environment_id} {task.controller}: {_line(outcome)}", highlight=False)
            progress.advance(bar)
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
    return ResultTable.of("validation of the searches", columns, rows)


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
