"""Evaluations as a table for the terminal, with the columns that the task declares."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Self

from rich.box import SIMPLE_HEAD
from rich.table import Table

from prp_gym.artifacts import to_array
from prp_gym.errors import InvalidValueError
from prp_gym.evaluation.column import Column
from prp_gym.evaluation.metrics import METRICS
from prp_gym.evaluation.statistics import Estimate
from prp_gym.robot.arrays import Array

_ABSENT = "-"
_TIME = "com-\npute\ntime\nµs"
_SMALLEST = 0.005
_TWO_DECIMALS_BELOW = 0.1
_WHOLE_FROM = 10.0
_POWER_OF_TEN_FROM = 9999.5  # rounds to five digits


@dataclass(frozen=True, eq=False)
class Row:
    """One line of the table.

    Attributes:
        baseline: name of the controller or policy.
        episodes: number of episodes.
        score: interquartile mean over the episodes, with its interval.
        median: median of every metric over the episodes, (components).
        compute_time: compute time of the policy for one action [s].
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
class _MetricColumn:
    """The column of a metric in a table.

    Attributes:
        metric: name of the metric.
        column: declared column of the metric.
    """

    metric: str
    column: Column

    def header(self, rows: Sequence[Row]) -> str:
        """Title and units, those of as many components as the rows have."""
        medians = (row.median for row in rows)
        count = max(len(median[self.metric]) for median in medians if self.metric in median)
        return f"{self.column.title}\n{' '.join(self.column.units[:count])}"

    def cell(self, row: Row) -> str:
        """The median of one row."""
        values = row.median.get(self.metric)
        return _ABSENT if values is None else _vector(self.column.scale * values)


def evaluation_table(
    title: str, rows: Sequence[Row], metrics: Iterable[str], who: str = "controller"
) -> Table:
    """Scores and medians over the episodes, best score first.

    Args:
        title: what was evaluated.
        rows: rows of one environment and scenario.
        metrics: metrics whose medians are shown, as the task declares them; those that no row has are left
            out.
        who: header of the names of the rows.

    Returns:
        a table for a terminal of 120 columns. Vectors are the joints [mrad, mm, mrad]; what is below 0.005
        is shown as 0.

    Raises:
        UnknownNameError: a metric that does not exist.
        InvalidValueError: a metric without a column.
    """
    columns = _columns(metrics, rows)
    table = Table(title=title, title_justify="left", box=SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))
    table.add_column(who, no_wrap=True, vertical="bottom")
    for header in ("score", "95 %\ninterval", *(column.header(rows) for column in columns), _TIME):
        table.add_column(header, justify="right", no_wrap=True, vertical="bottom")
    for row in sorted(rows, key=lambda row: -row.score.value):
        cells = [column.cell(row) for column in columns]
        table.add_row(row.baseline, *_score(row), *cells, _number(round(1e6 * row.compute_time)))
    return table


def _columns(metrics: Iterable[str], rows: Sequence[Row]) -> list[_MetricColumn]:
    present = {name for row in rows for name in row.median}
    columns = []
    for name in metrics:
        column = METRICS.find(name).column
        if column is None:
            raise InvalidValueError("metric of a table's column", name, "one that declares a column")
        if name in present:
            columns.append(_MetricColumn(name, column))
    return columns


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
