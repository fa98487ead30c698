"""The command `prp-gym list`."""

from typing import Annotated

import gymnasium
import typer
from rich.box import SIMPLE_HEAD
from rich.table import Table

from prp_gym.action_modes import ACTION_MODES, ANY_CONTROLLER, list_action_modes
from prp_gym.agents.algorithms import ALGORITHMS
from prp_gym.baselines import BASELINES
from prp_gym.baselines.base.gains import gain_sets
from prp_gym.cli.options import Plugins
from prp_gym.envs.action_mode import TORQUE
from prp_gym.evaluation.metrics import METRICS
from prp_gym.runs.terminal import make_console, make_matrix
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
    plugin: Plugins = None,
) -> None:
    """Show environments, controllers and scenarios, or what the options name."""
    console = make_console()
    layouts = _layouts() if matrix or modes or not (algorithms or metrics) else {}
    if matrix:
        for table in _matrix(layouts):
            console.print(table)
        for reason in _reasons(layouts):
            console.print(reason)
    if modes:
        console.print(_modes(layouts))
    if algorithms:
        console.print(_algorithms())
    if metrics:
        console.print(_metrics())
    if not (matrix or modes or algorithms or metrics):
        for table in (_environments(layouts), _controllers()):
            console.print(table)
        console.print(f"scenarios: {', '.join(SCENARIOS)}")


def _layouts() -> dict[str, ObservationLayout]:
    """Observation layout of every environment, by id."""
    layouts = {}
    for entry in TASKS.values():
        made = gymnasium.make(entry.id)
        layouts[entry.id] = made.get_wrapper_attr("observation_layout")
        made.close()
    return layouts


def _table(title: str, headers: tuple[str, ...]) -> Table:
    table = Table(title=title, title_justify="left", box=SIMPLE_HEAD, pad_edge=False, padding=(0, 2, 0, 0))
    for header in headers:
        table.add_column(header, overflow="fold")
    return table


def _environments(layouts: dict[str, ObservationLayout]) -> Table:
    table = _table("environments", ("id", "task", "observation fields"))
    for entry in TASKS.values():
        table.add_row(entry.id, entry.summary, ", ".join(layouts[entry.id].names))
    return table


def _controllers() -> Table:
    table = _table("controllers", ("controller", "summary", "gain sets"))
    for name, controller in BASELINES.items():
        table.add_row(name, controller.summary, ", ".join(gain_sets(name)))
    return table


def _modes(layouts: dict[str, ObservationLayout]) -> Table:
    table = _table("action modes", ("mode", "inner controller", "an action", "environments"))
    where = {name: list_action_modes(layout) for name, layout in layouts.items()}
    table.add_row(TORQUE, "", "is the joint torques", "all")
    for spec in ACTION_MODES.values():
        conditions = [name.removeprefix("PRP-") for name, modes in where.items() if spec.name in modes]
        shown = "all" if len(conditions) == len(where) else ", ".join(conditions)
        shown = f"where {ANY_CONTROLLER} runs" if spec.is_family else shown
        table.add_row(spec.label, spec.entry.controller, spec.summary, shown)
    return table


def _algorithms() -> Table:
    table = _table("learning algorithms", ("algorithm", "summary", "class"))
    for name, spec in ALGORITHMS.items():
        table.add_row(name, spec.summary, f"{spec.entry.package}.{spec.entry.class_name}")
    return table


def _metrics() -> Table:
    table = _table("metrics", ("metric", "units", "definition"))
    for name, metric in METRICS.items():
        table.add_row(name, ", ".join(metric.units), metric.definition)
    return table


def _matrix(layouts: dict[str, ObservationLayout]) -> list[Table]:
    rows = (
        (name, ["-" if controller.missing_fields(layout) else "yes" for controller in BASELINES.values()])
        for name, layout in layouts.items()
    )
    return make_matrix("controllers by environment", BASELINES, rows)


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
