"""The command `prp-gym list`."""

from collections.abc import Sequence
from typing import Annotated

import gymnasium
import typer

from prp_gym.action_modes import ACTION_MODES, ANY_CONTROLLER, list_action_modes
from prp_gym.agents.algorithms import ALGORITHMS
from prp_gym.baselines import BASELINES
from prp_gym.baselines.base.gains import gain_sets
from prp_gym.cli.options import (
    Json,
    Plugins,
    TableFormat,
)
from prp_gym.console.terminal import Terminal
from prp_gym.envs.action_mode import TORQUE
from prp_gym.envs.base.scenarios import load_scenario
from prp_gym.evaluation.metrics import METRICS
from prp_gym.tables import Cell, ResultTable
from prp_gym.tables.column import prose_column, text_column
from prp_gym.tables.formats import TERMINAL
from prp_gym.tables.matrix import matrix_table
from prp_gym.tasks.fields import ObservationLayout
from prp_gym.tasks.scenario import SCENARIOS
from prp_gym.tasks.spec import TASKS

_MATRIX = "controllers by environment"
_NAMES = ("id", "controller", "scenario", "mode", "algorithm", "class", "metric")  # all other columns wrap

Row = dict[str, str | list[str]]
"""One declaration: texts, or lists of them, by the headers of the table."""


def list_command(
    matrix: Annotated[
        bool,
        typer.Option("--matrix", help="Show which controller runs on which environment, or why it does not."),
    ] = False,
    modes: Annotated[
        bool, typer.Option("--modes", help="Show the action modes and their environments.")
    ] = False,
    algorithms: Annotated[bool, typer.Option("--algorithms", help="Show the learning algorithms.")] = False,
    metrics: Annotated[
        bool, typer.Option("--metrics", help="Show the metrics with their units and definitions.")
    ] = False,
    form: TableFormat = TERMINAL,
    as_json: Json = False,
    plugin: Plugins = None,
) -> None:
    """Show environments, controllers and scenarios, or what the options name."""
    terminal = Terminal.of(quiet=False, as_json=as_json, form=form)
    layouts = _layouts() if matrix or modes or not (algorithms or metrics) else {}
    rows: dict[str, list[Row]] = {}
    if matrix:
        rows[_MATRIX] = _matrix(layouts)
    if modes:
        rows["action modes"] = _modes(layouts)
    if algorithms:
        rows["learning algorithms"] = _algorithms()
    if metrics:
        rows["metrics"] = _metrics()
    if not rows:
        rows = {"environments": _environments(layouts), "controllers": _controllers()}
        rows["scenarios"] = _scenarios()
    tables = [
        _matrix_table(title, found) if title == _MATRIX else _table(title, found)
        for title, found in rows.items()
    ]
    content = {title.replace(" ", "_"): found for title, found in rows.items()}
    terminal.report(content, tables, _reasons(layouts) if matrix else ())


def _layouts() -> dict[str, ObservationLayout]:
    """Observation layout of every environment, by id."""
    layouts = {}
    for entry in TASKS.values():
        made = gymnasium.make(entry.id)
        layouts[entry.id] = made.get_wrapper_attr("observation_layout")
        made.close()
    return layouts


def _table(title: str, rows: Sequence[Row]) -> ResultTable:
    columns = [text_column(name) if name in _NAMES else prose_column(name) for name in rows[0]]
    return ResultTable.of(title, columns, [[_cell(entry) for entry in row.values()] for row in rows])


def _cell(entry: str | list[str]) -> Cell:
    return Cell.of(entry) if isinstance(entry, str) else Cell(", ".join(entry), entry)


def _environments(layouts: dict[str, ObservationLayout]) -> list[Row]:
    return [
        {"id": entry.id, "task": entry.summary, "observation fields": list(layouts[entry.id].names)}
        for entry in TASKS.values()
    ]


def _controllers() -> list[Row]:
    return [
        {"controller": name, "summary": controller.summary, "gain sets": list(gain_sets(name))}
        for name, controller in BASELINES.items()
    ]


def _scenarios() -> list[Row]:
    return [{"scenario": name, "description": load_scenario(name).description} for name in SCENARIOS]


def _modes(layouts: dict[str, ObservationLayout]) -> list[Row]:
    where = {name: list_action_modes(layout) for name, layout in layouts.items()}
    rows: list[Row] = [_mode(TORQUE, "", "is the joint torques", ["all"])]
    for spec in ACTION_MODES.values():
        conditions = [name.removeprefix("PRP-") for name, modes in where.items() if spec.name in modes]
        shown = ["all"] if len(conditions) == len(where) else conditions
        shown = [f"where {ANY_CONTROLLER} runs"] if spec.is_family else shown
        rows.append(_mode(spec.label, spec.entry.controller, spec.summary, shown))
    return rows


def _mode(name: str, controller: str, summary: str, environments: list[str]) -> Row:
    return {
        "mode": name,
        "inner controller": controller,
        "an action": summary,
        "environments": environments,
    }


def _algorithms() -> list[Row]:
    return [
        {
            "algorithm": name,
            "summary": spec.summary,
            "class": f"{spec.entry.package}.{spec.entry.class_name}",
        }
        for name, spec in ALGORITHMS.items()
    ]


def _metrics() -> list[Row]:
    return [
        {"metric": name, "units": list(metric.units), "definition": metric.definition}
        for name, metric in METRICS.items()
    ]


def _matrix(layouts: dict[str, ObservationLayout]) -> list[Row]:
    return [
        {
            "environment": name,
            "controllers": [
                own for own, controller in BASELINES.items() if not controller.missing_fields(layout)
            ],
        }
        for name, layout in layouts.items()
    ]


def _matrix_table(title: str, rows: Sequence[Row]) -> ResultTable:
    cells = (
        (str(row["environment"]), [_runs(name in row["controllers"]) for name in BASELINES]) for row in rows
    )
    return matrix_table(title, BASELINES, cells)


def _runs(can: bool) -> Cell:
    return Cell("yes" if can else "-", can)


def _reasons(layouts: dict[str, ObservationLayout]) -> list[str]:
    """Fields that some controllers read and some environments do not observe."""
    lacking: dict[str, tuple[list[str], list[str]]] = {}
    for environment_id, layout in layouts.items():
        for name, controller in BASELINES.items():
            for field in controller.missing_fields(layout):
                controllers, conditions = lacking.setdefault(field, ([], []))
                controllers += [name] * (name not in controllers)
                conditions += [environment_id] * (environment_id not in conditions)
    return [
        f"{field}: read by {', '.join(controllers)}; not observed by {', '.join(conditions)}"
        for field, (controllers, conditions) in lacking.items()
    ]
