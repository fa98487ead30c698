"""Evaluations as a table for the terminal."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Self

from rich.box import SIMPLE_HEAD
from rich.table import Table

from prp_gym.evaluation.results import to_array
from prp_gym.evaluation.statistics import Estimate
from prp_gym.robot.arrays import Array

_ABSENT = "-"
_SMALLEST = 0.005
_TWO_DECIMALS_BELOW = 0.1
_WHOLE_FROM = 10.0
_POWER_OF_TEN_FROM = 9999.5  # rounds to five digits


@dataclass(frozen=True, eq=False)
class Row:
    """One line of the table.

    Attributes:
        baseline: the law.
        episodes: how many.
        score: over the episodes.
        median: over the episodes of every metric, (components).
        compute_time: of an action [s].
    """

    baseline: str
    episodes: int
    score: Estimate
    median: Mapping[str, Array]
    compute_time: float

    @classmethod
    def of(cls, record: Mapping[str, Any]) -> Self:
        """From an evaluation as the results file holds it."""
        return cls(
            baseline=record["baseline"],
            episodes=len(record["seeds"]),
            score=Estimate(*to_array([record["score"][name] for name in Estimate._fields]).tolist()),
            median={name: to_array(values) for name, values in record["median"].items()},
            compute_time=record["compute_time_per_step"],
        )


@dataclass(frozen=True)
class Column:
    """A declared column: the median of a metric, in an environment where that metric exists.

    Attributes:
        title: above the unit, with line breaks.
        units: of the shown numbers, one a component; of fewer components the first units.
        metric: whose median is shown.
        scale: shown number over the metric's own.
        unless: a metric that says more: where it exists, the column is left out. Empty for none.
    """

    title: str
    units: tuple[str, ...]
    metric: str
    scale: float = 1.0
    unless: str = ""

    def belongs(self, rows: Sequence[Row]) -> bool:
        """Whether the rows' environment has the metric, and none that says more."""
        names = {name for row in rows for name in row.median}
        return self.metric in names and self.unless not in names

    def header(self, rows: Sequence[Row]) -> str:
        """Title and units, those of as many components as the rows have."""
        medians = (row.median for row in rows)
        count = max(len(median[self.metric]) for median in medians if self.metric in median)
        return f"{self.title}\n{' '.join(self.units[:count])}"

    def cell(self, row: Row) -> str:
        """The median of one row."""
        values = row.median.get(self.metric)
        return _ABSENT if values is None else _vector(self.scale * values)


_JOINTS = ("mrad", "mm", "mrad")

COLUMNS = (
    Column("joint RMSE", _JOINTS, "joint_rmse", 1e3),
    Column("steady error", _JOINTS, "steady_state_error", 1e3),
    Column("settle", ("s",), "settling_time"),
    Column("over-\nshoot", ("%",), "overshoot"),
    # in contact a tip that gives way is what is asked for, not an error
    Column("pos.\nRMSE", ("mm",), "position_rmse", 1e3, unless="peak_force"),
    Column("angle\nRMSE", ("mrad",), "orientation_rmse", 1e3, unless="model_orientation_rmse"),
    Column("steady\nerror", ("mm",), "position_steady_state_error", 1e3, unless="peak_force"),
    Column("settle", ("s",), "position_settling_time", unless="peak_force"),
    Column("over-\nshoot", ("%",), "position_overshoot", unless="peak_force"),
    Column("model\nerror", ("mm",), "model_position_rmse", 1e3),
    Column("model\nerror", ("mrad",), "model_orientation_rmse", 1e3),
    Column("force\nRMSE", ("N",), "force_rmse"),
    Column("final\nerror", ("N",), "steady_state_force_error"),
    Column("force\nsettle", ("s",), "force_settling_time"),
    Column("peak\nforce", ("N",), "peak_force"),
    Column("los-\nses", ("1",), "contact_losses"),
    Column("in-\njected", ("mJ",), "injected_energy", 1e3),
    Column("energy", ("J",), "energy"),
    Column("sat.", ("%",), "saturation"),
)
"""In the order of the table; together with law, score and time they hold in 120 columns for every task."""


def evaluation_table(
    title: str, rows: Sequence[Row], who: str = "controller", timed: str = "law\nµs"
) -> Table:
    """Scores and medians over the episodes, best score first.

    Args:
        title: what was evaluated.
        rows: of one environment and scenario.
        who: what the rows are, above their names.
        timed: above their compute times.

    Returns:
        a table for a terminal of 120 columns, with those of `COLUMNS` that the environment has. Vectors
        are the joints [mrad, mm, mrad]; what is below 0.005 is shown as 0.
    """
    columns = [column for column in COLUMNS if column.belongs(rows)]
    table = Table(title=title, title_justify="left", box=SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))
    table.add_column(who, no_wrap=True, vertical="bottom")
    for header in ("score", "95 %\ninterval", *(column.header(rows) for column in columns), timed):
        table.add_column(header, justify="right", no_wrap=True, vertical="bottom")
    for row in sorted(rows, key=lambda row: -row.score.value):
        cells = [column.cell(row) for column in columns]
        table.add_row(row.baseline, *_score(row), *cells, _number(round(1e6 * row.compute_time)))
    return table


def _score(row: Row) -> tuple[str, str]:
    score = row.score
    interval = f"{score.low:.3f}-{score.high:.3f}" if row.episodes > 1 else "1 episode"
    return f"{score.value:.3f}", interval


def _vector(values: Array) -> str:
    if all(math.isnan(value) for value in values):
        return _ABSENT
    return " ".join(_number(value) for value in values.tolist())


def _number(value: float) -> str:
    """In at most four characters and a sign, or as a word."""
    if math.isnan(value):
        return _ABSENT
    if math.isinf(value):
        return "never"
    if abs(value) < _SMALLEST:
        return "0"
    if abs(value) < _TWO_DECIMALS_BELOW:
        return f"{value:.2f}"
    if abs(value) < _WHOLE_FROM:
        return f"{value:.2g}"
    if abs(value) < _POWER_OF_TEN_FROM:
        return f"{value:.0f}"
    mantissa, exponent = f"{value:.0e}".split("e")
    return f"{mantissa}e{int(exponent)}"
