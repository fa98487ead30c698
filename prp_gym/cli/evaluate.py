"""The command `prp-gym evaluate`."""

import itertools
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from prp_gym.cli.options import (
    Backend,
    ControllerNames,
    Environments,
    FirstSeed,
    Fresh,
    Gains,
    ParallelWorkers,
    Plugins,
    Settings,
)
from prp_gym.evaluation.evaluate import check_protocol
from prp_gym.evaluation.scoring import scoring_of
from prp_gym.evaluation.table import Row, evaluation_table
from prp_gym.runs.choice import TUNED, GainsChoice
from prp_gym.runs.evaluation_job import list_jobs
from prp_gym.runs.job import Record
from prp_gym.runs.run import Run
from prp_gym.runs.selection import Selection
from prp_gym.runs.terminal import TABLE_WIDTH, make_console, make_matrix
from prp_gym.runs.workers import Workers

_DEFAULT_SCENARIOS = ["report", "randomized"]


def evaluate_command(
    env: Environments = None,
    baseline: ControllerNames = None,
    scenario: Annotated[
        list[str] | None, typer.Option(help="Scenario; repeatable. Default: report and randomized.")
    ] = None,
    episodes: Annotated[int, typer.Option(help="Episodes of each controller on each environment.")] = 20,
    seed: FirstSeed = 0,
    gains: Gains = TUNED,
    settings: Settings = None,
    control_frequency: Annotated[float, typer.Option(help="Control frequency [Hz].")] = 500.0,
    output: Annotated[Path, typer.Option(help="Folder for results.json.")] = Path("results"),
    jobs: ParallelWorkers = 0,
    backend: Backend = "loky",
    fresh: Fresh = False,
    plugin: Plugins = None,
) -> None:
    """Evaluate controllers and print a table.

    A run that was interrupted goes on where it stopped when the same command is given again.
    """
    workers = Workers(jobs, backend)
    chosen = GainsChoice.read(gains, settings or ())
    selected = Selection.of(env or [], scenario or _DEFAULT_SCENARIOS, baseline or [], chosen)
    check_protocol(episodes, seed)
    listed = list_jobs(
        selected.conditions, selected.choices, selected.controllers, control_frequency, episodes, seed
    )
    selected.check_used(listed)
    run = Run(output, workers, selected.controllers, fresh)
    with run.hold(listed):
        records = run.records(listed, "evaluating")
        run.write(listed, records, {})
    _show(records, run)


def _show(records: list[Record], run: Run) -> None:
    """Print the tables, with notes that explain them."""
    console = make_console(least=TABLE_WIDTH)  # where a terminal is narrower, lines wrap and no cell is cut
    for table in (*_tables(records), *_scores(records)):
        console.print(table)
    console.print(
        "score: interquartile mean over episodes of the mean reward, 1 is perfect; other figures are medians."
    )
    if run.busy:
        console.print("compute time: measured beside other work; for undisturbed times choose --jobs 1.")
    console.print(f"results: {run.results}", highlight=False)


def _tables(records: list[Record]) -> Iterator[Table]:
    """A table for each condition, in the order of the records."""
    for (environment_id, scenario), own in itertools.groupby(
        records, lambda record: (record["environment"], record["scenario"])
    ):
        rows = [Row.of(record) for record in own]
        columns = scoring_of(environment_id).columns
        yield evaluation_table(f"{environment_id}, scenario {scenario}", rows, columns)


def _scores(records: list[Record]) -> list[Table]:
    """The scores alone, a table for each scenario; none where there is one environment only."""
    controllers = list(dict.fromkeys(record["baseline"] for record in records))
    scores = {(r["scenario"], r["environment"], r["baseline"]): r["score"]["value"] for r in records}
    ids = list(dict.fromkeys(record["environment"] for record in records))
    if len(ids) == 1:
        return []
    tables: list[Table] = []
    for scenario in dict.fromkeys(record["scenario"] for record in records):
        rows = []
        for environment_id in ids:
            own = [scores.get((scenario, environment_id, controller)) for controller in controllers]
            best = max(value for value in own if value is not None)
            cells = ["-" if v is None else f"{v:.3f}" + ("*" if v == best else " ") for v in own]
            rows.append((environment_id, cells))
        tables += make_matrix(f"score, scenario {scenario} (* best)", controllers, rows)
    return tables
