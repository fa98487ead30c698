"""The command `prp-gym evaluate`."""

from collections.abc import Iterator
from typing import Any

from prp_gym.cli.compiler_note import note_missing_compiler
from prp_gym.cli.options import (
    Backend,
    ControlFrequency,
    ControllerNames,
    Engine,
    Environments,
    Episodes,
    Gains,
    Json,
    ParallelWorkers,
    Plugins,
    Quiet,
    Resume,
    RunName,
    RunOutput,
    Scenarios,
    Seed,
    Settings,
    TableFormat,
)
from prp_gym.console.terminal import Terminal
from prp_gym.evaluation.evaluate import check_protocol
from prp_gym.evaluation.rollout import condition_name
from prp_gym.evaluation.scoring import scoring_of
from prp_gym.evaluation.table import SCORE_NOTE, Row, best_floor, evaluation_table, ranked, score_table
from prp_gym.runs.choice import TUNED, GainsChoice
from prp_gym.runs.evaluation_job import EvaluationJob, list_jobs
from prp_gym.runs.floor_job import FloorJob, list_floors
from prp_gym.runs.job import Record, describe_jobs
from prp_gym.runs.result_folder import ResultFolder
from prp_gym.runs.run import Run
from prp_gym.runs.selection import Selection
from prp_gym.runs.workers import Workers
from prp_gym.tables import ABSENT, Cell, ResultTable
from prp_gym.tables.formats import TERMINAL
from prp_gym.tables.matrix import matrix_table
from prp_gym.tasks.setup import MUJOCO

Conditions = list[tuple[str, str, list[Row]]]
"""Environment, scenario and rows of each condition."""

_DEFAULT_SCENARIOS = ["report", "randomized"]


def evaluate_command(
    env: Environments = None,
    baseline: ControllerNames = None,
    scenario: Scenarios = _DEFAULT_SCENARIOS,
    episodes: Episodes = 20,
    seed: Seed = 0,
    gains: Gains = TUNED,
    settings: Settings = None,
    control_frequency: ControlFrequency = 500.0,
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
    """Evaluate controllers and print a table.

    Every controller is run on every environment that observes what it reads. A run that was interrupted goes
    on where it stopped when the same command is given again.
    """
    workers = Workers(jobs, backend)
    chosen = GainsChoice.read(gains, settings or ())
    selected = Selection.of(env or [], scenario, baseline or [], chosen)
    check_protocol(episodes, seed)
    terminal = Terminal.of(quiet, as_json, form)
    note_missing_compiler(terminal, selected.notes)
    with terminal.progress("trying out the controllers"):
        listed = list_jobs(
            selected.conditions,
            selected.choices,
            selected.controllers,
            control_frequency,
            episodes,
            seed,
            engine,
        )
    selected.check_used(listed)
    floors = list_floors(selected.conditions, control_frequency, episodes, seed, engine=engine)
    jobs_to_run: list[EvaluationJob | FloorJob] = [*listed, *floors]
    folder = ResultFolder.choose("evaluate", output, name, describe_jobs(jobs_to_run), goes_on=resume)
    run = Run(folder.path, workers, selected.controllers, not resume, terminal)
    with run.hold(jobs_to_run), folder.in_use():
        records = run.records(jobs_to_run, "evaluating")
        conditions = _conditions(records)
        content = run.write(jobs_to_run, records, {"ranking": _ranking(conditions)})
    tables = [*_tables(conditions, engine), *_scores(conditions)]
    terminal.report(content, tables, _notes(run), [f"results: {run.results}"])


def _notes(run: Run) -> Iterator[str]:
    """What explains the tables."""
    yield f"score: mean over episodes of the mean reward of a step, 1 is perfect. {SCORE_NOTE}"
    if run.busy:
        yield "compute time: measured beside other work; for undisturbed times choose --jobs 1."


def _conditions(records: list[Record]) -> Conditions:
    """Environment, scenario and rows of each condition, in the order of the records."""
    rows: dict[tuple[str, str], list[Row]] = {}
    for record in records:
        rows.setdefault((record["environment"], record["scenario"]), []).append(Row.of(record))
    return [(*key, own) for key, own in rows.items()]


def _tables(conditions: Conditions, engine: str) -> Iterator[ResultTable]:
    """Two tables for each condition: scores and failures, and the medians of the metrics."""
    for environment_id, scenario, rows in conditions:
        title = condition_name(environment_id, scenario, engine)
        yield score_table(f"{title}: scores", rows)
        yield evaluation_table(title, rows, scoring_of(environment_id).columns)


def _ranking(conditions: Conditions) -> list[dict[str, Any]]:
    """The controllers of each condition by their scores, best first, with their skill over the best floor."""
    return [
        {
            "environment": environment_id,
            "scenario": scenario,
            "baseline": row.baseline,
            "floor": row.floor,
            "score": row.score.value,
            "skill": row.summary.skill(best_floor(rows)),
        }
        for environment_id, scenario, rows in conditions
        for row in ranked(rows)
    ]


def _scores(conditions: Conditions) -> list[ResultTable]:
    """The scores alone, a table for each scenario; none where there is one environment only."""
    ids = list(dict.fromkeys(environment_id for environment_id, _, _ in conditions))
    if len(ids) == 1:
        return []
    every = [row for _, _, rows in conditions for row in rows]
    names = list(dict.fromkeys(row.name for row in sorted(every, key=lambda row: row.floor)))
    tables = []
    for scenario in dict.fromkeys(scenario for _, scenario, _ in conditions):
        lines = [(own, _cells(names, rows)) for own, other, rows in conditions if other == scenario]
        tables.append(matrix_table(f"score, scenario {scenario} (* best)", names, lines))
    return tables


def _cells(names: list[str], rows: list[Row]) -> list[Cell]:
    """The score of each name, with an asterisk at the best controller."""
    values = {row.name: row.score.value for row in rows}
    best = ranked(rows)[0].name
    return [
        Cell(f"{values[name]:.3f}{'*' if name == best else ' '}", values[name]) if name in values else ABSENT
        for name in names
    ]
