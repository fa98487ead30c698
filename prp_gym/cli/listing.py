"""The command `prp-gym list`."""

from typing import Annotated

import gymnasium
import typer

from prp_gym.action_modes import ACTION_MODES, ANY_CONTROLLER, list_action_modes
from prp_gym.agents.algorithms import ALGORITHMS
from prp_gym.baselines import BASELINES
from prp_gym.baselines.base.gains import gain_sets
from prp_gym.cli.options import Plugins, TableFormat
from prp_gym.cli.shown import show_tables
from prp_gym.envs.action_mode import TORQUE
from prp_gym.evaluation.metrics import METRICS
from prp_gym.tables import Cell, ResultTable
from prp_gym.tables.column import prose_column, text_column
from prp_gym.tables.formats import TERMINAL
from prp_gym.tables.matrix import matrix_table
from prp_gym.tasks.fields import ObservationLayout
from prp_gym.tasks.scenario import SCENARIOS
from prp_gym.tasks.spec import TASKS


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
    plugin: Plugins = None,
) -> None:
    """Show environments, controllers and scenarios, or what the options name."""
    layouts = _layouts() if matrix or modes or not (algorithms or metrics) else {}
    tables, notes = [], []
    if matrix:
        tables.append(_matrix(layouts))
        notes += _reasons(layouts)
    if modes:
        tables.append(_modes(layouts))
    if algorithms:
        tables.append(_algorithms())
    if metrics:
        tables.append(_metrics())
    if not (matrix or modes or algorithms or metrics):
        tables += [_environments(layouts), _controllers()]
        notes.append(f"scenarios: {', '.join(SCENARIOS)}")
    show_tables(tables, notes, form)


def _layouts() -> dict[str, ObservationLayout]:
    """Observation layout of every environment, by id."""
    layouts = {}
    for entry in TASKS.values():
        made = gymnasium.make(entry.id)
        layouts[entry.id] = made.get_wrapper_attr("observation_layout")
        made.close()
    return layouts


def _environments(layouts: dict[str, ObservationLayout]) -> ResultTable:
    columns = (text_column("id"), prose_column("task"), prose_column("observation fields"))
    rows = [(entry.id, entry.summary, ", ".join(layouts[entry.id].names)) for entry in TASKS.values()]
    return ResultTable.of("environments", columns, rows)


def _controllers() -> ResultTable:
    columns = (text_column("controller"), prose_column("summary"), prose_column("gain sets"))
    rows = [(name, spec.summary, ", ".join(gain_sets(name))) for name, spec in BASELINES.items()]
    return ResultTable.of("controllers", columns, rows)


def _modes(layouts: dict[str, ObservationLayout]) -> ResultTable:
    columns = (
        *(text_column("mode"), prose_column("inner controller")),
        *(prose_column("an action"), prose_column("environments")),
    )
    rows = [(TORQUE, "", "is the joint torques", "all")]
    where = {name: list_action_modes(layout) for name, layout in layouts.items()}
    for spec in ACTION_MODES.values():
        conditions = [name.removeprefix("PRP-") for name, modes in where.items() if spec.name in modes]
        shown = "all" if len(conditions) == len(where) else ", ".join(conditions)
        shown = f"where {ANY_CONTROLLER} runs" if spec.is_family else shown
        rows.append((spec.label, spec.entry.controller, spec.summary, shown))
    return ResultTable.of("action modes", columns, rows)


def _algorithms() -> ResultTable:
    columns = (text_column("algorithm"), prose_column("summary"), text_column("class"))
    rows = [
        (name, spec.summary, f"{spec.entry.package}.{spec.entry.class_name}")
        for name, spec in ALGORITHMS.items()
    ]
    return ResultTable.of("learning algorithms", columns, rows)


def _metrics() -> ResultTable:
    columns = (text_column("metric"), text_column("units"), prose_column("definition"))
    rows = [(name, ", ".join(metric.units), metric.definition) for name, metric in METRICS.items()]
    return ResultTable.of("metrics", columns, rows)


def _matrix(layouts: dict[str, ObservationLayout]) -> ResultTable:
    rows = (
        (name, [_runs(not controller.missing_fields(layout)) for controller in BASELINES.values()])
        for name, layout in layouts.items()
    )
    return matrix_table("controllers by environment", BASELINES, rows)


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
