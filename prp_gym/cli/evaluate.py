"""The command `prp-gym evaluate`."""

import itertools
import shlex
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from prp_gym.baselines import BASELINES
from prp_gym.baselines.gains import gain_sets
from prp_gym.cli.options import Backend, Controllers, Environments, FirstSeed, Fresh, ParallelWorkers
from prp_gym.cli.terminal import TABLE_WIDTH, make_console, make_matrix
from prp_gym.errors import InvalidValueError, UnknownNameError
from prp_gym.evaluation.evaluate import check_protocol
from prp_gym.evaluation.results import describe_run, prepare_folder, write_json
from prp_gym.evaluation.scoring import scoring_of
from prp_gym.evaluation.table import Row, evaluation_table
from prp_gym.registration import list_envs
from prp_gym.runs.job import EvaluationJob, Record, list_jobs
from prp_gym.runs.run import check_names, run_jobs
from prp_gym.runs.store import JobStore
from prp_gym.runs.workers import Workers
from prp_gym.tasks.scenario import SCENARIOS

_DEFAULT_SCENARIOS = ("report", "randomized")


def evaluate_command(
    env: Environments = None,
    baseline: Controllers = None,
    scenario: Annotated[
        list[str] | None, typer.Option(help="Scenario; repeatable. Default: report and randomized.")
    ] = None,
    episodes: Annotated[int, typer.Option(help="Episodes of each pair.")] = 20,
    seed: FirstSeed = 0,
    gains: Annotated[str, typer.Option(help="Gain set of the laws.")] = "tuned",
    control_frequency: Annotated[float, typer.Option(help="Actions a second [Hz].")] = 500.0,
    output: Annotated[Path, typer.Option(help="Folder for results.json.")] = Path("results"),
    jobs: ParallelWorkers = 0,
    backend: Backend = "loky",
    fresh: Fresh = False,
) -> None:
    """Evaluate classical baselines and print a table.

    A run that was interrupted goes on where it stopped when the same command is given again.
    """
    workers = Workers(jobs, backend)
    ids = check_names("environment", env or [], list_envs())
    controllers = check_names("baseline", baseline or [], _controllers_with(gains))
    scenarios = check_names("scenario", scenario or list(_DEFAULT_SCENARIOS), list(SCENARIOS))
    check_protocol(episodes, seed)
    pairs = list_jobs(
        itertools.product(ids, scenarios), controllers, gains, control_frequency, episodes, seed
    )
    _check_used(baseline or [], pairs)
    finished = JobStore(output / "pairs")
    for folder in (output, output / "pairs"):
        prepare_folder(folder)
    if fresh:
        finished.remove(pairs)
    records = run_jobs(pairs, workers, finished, "evaluating")
    target = output / "results.json"
    command = shlex.join(["prp-gym", *sys.argv[1:]])
    write_json(target, {**describe_run(command), "evaluations": records})
    finished.remove(pairs)
    _show(records, target, busy=jobs != 1)


def _controllers_with(gains: str) -> list[str]:
    """The laws that have a gain set."""
    controllers = [name for name in BASELINES if gains in gain_sets(name)]
    if not controllers:
        raise UnknownNameError("gain set", gains, {item for name in BASELINES for item in gain_sets(name)})
    return controllers


def _check_used(controllers: list[str], pairs: list[EvaluationJob]) -> None:
    """Refuse a law that was asked for by name and runs on none of the environments."""
    used = {pair.controller for pair in pairs}
    for controller in controllers:
        if controller not in used:
            raise InvalidValueError(
                "baseline", controller, f"a law that runs on the chosen environments: {sorted(used)}"
            )


def _show(records: list[Record], target: Path, busy: bool) -> None:
    """Print the tables, and what to know of them; `busy` if other work ran beside each pair."""
    console = make_console(least=TABLE_WIDTH)  # where a terminal is narrower, lines wrap and no cell is cut
    for table in (*_tables(records), *_scores(records)):
        console.print(table)
    console.print(
        "score: interquartile mean over episodes of return/duration, 1 is perfect; other figures are medians."
    )
    if busy:
        console.print(
            "compute time: per action, measured beside other work; for undisturbed times choose --jobs 1."
        )
    console.print(f"results: {target}", highlight=False)


def _tables(records: list[Record]) -> Iterator[Table]:
    """A table a place, in the order of the records."""
    for (environment_id, scenario), own in itertools.groupby(
        records, lambda record: (record["environment"], record["scenario"])
    ):
        rows = [Row.of(record) for record in own]
        columns = scoring_of(environment_id).columns
        yield evaluation_table(f"{environment_id}, scenario {scenario}", rows, columns)


def _scores(records: list[Record]) -> list[Table]:
    """The scores alone, a table a scenario; none where there is one environment only."""
    controllers = list(dict.fromkeys(record["baseline"] for record in records))
    scores = {(r["scenario"], r["environment"], r["baseline"]): r["score"]["value"] for r in records}
    ids = list(dict.fromkeys(record["environment"] for record in records))
    if len(ids) == 1:
        return []
    tables = []
    for scenario in dict.fromkeys(record["scenario"] for record in records):
        rows = []
        for environment_id in ids:
            own = [scores.get((scenario, environment_id, controller)) for controller in controllers]
            best = max(value for value in own if value is not None)
            cells = ["-" if v is None else f"{v:.3f}" + ("*" if v == best else " ") for v in own]
            rows.append((environment_id, cells))
        tables.append(make_matrix(f"score, scenario {scenario} (* best)", controllers, rows))
    return tables
