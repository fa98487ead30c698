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
from prp_gym.evaluation.score_summary import ScoreSummary
from prp_gym.evaluation.statistics import Estimate
from prp_gym.robot.arrays import Array

SCORE_NOTE = (
    "worst twentieth: mean of the worst 5 % of the episodes, of one at least; skill: share of what lies "
    "between the best floor and 1; failed: share of episodes, each counted once. Other figures are medians."
)
"""Explanation of the columns of `score_table`, and of the other figures."""

_ABSENT = "-"
_TIME = "com-\npute\ntime\nµs"
_SCORES = (
    "score",
    "95 %\ninterval",
    "inter-\nquartile\nmean",
    "worst\ntwen-\ntieth",
    "skill",
)
_FAILED = ("di-\nverged", "excess\nforce", "limit\ncycle", "un-\nset-\ntled")  # in the order of `FAILURES`
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
        summary: scores of the episodes, and how many of them failed.
        median: median of every metric over the episodes, (components).
        compute_time: compute time of the policy for one action [s].
        floor: whether the policy does not attempt the task; it is listed last and not ranked.
    """

    baseline: str
    episodes: int
    summary: ScoreSummary
    median: Mapping[str, Array]
    compute_time: float
    floor: bool = False

    @classmethod
    def of(cls, record: Mapping[str, Any]) -> Self:
        """From an evaluation as the results file holds it."""
        return cls(
            baseline=record["baseline"],
            episodes=len(record["seeds"]),
            summary=ScoreSummary.of_record(record),
            median={name: to_array(values) for name, values in record["median"].items()},
            compute_time=record["compute_time_per_step"],
            floor=bool(record.get("floor", False)),
        )

    @property
    def score(self) -> Estimate:
        """Mean over the episodes with its interval, by which rows are ranked."""
        return self.summary.mean

    @property
    def name(self) -> str:
        """The name as tables show it."""
        return f"{self.baseline} (floor)" if self.floor else self.baseline


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
    """Mean scores and medians of the metrics, best score first and the floors last.

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
    headers = ("score", "95 %\ninterval", *(column.header(rows) for column in columns), _TIME)
    table = _make(title, who, headers)
    for row in ranked(rows):
        cells = [column.cell(row) for column in columns]
        table.add_row(row.name, *_score(row), *cells, _number(round(1e6 * row.compute_time)))
    return table


def score_table(title: str, rows: Sequence[Row], who: str = "controller") -> Table:
    """Scores, what their mean hides, and the failed episodes by kind; best first and the floors last.

    Args:
        title: what was evaluated.
        rows: rows of one environment and scenario.
        who: header of the names of the rows.
    """
    floor = best_floor(rows)
    failed = (f"{'failed:' if index == 0 else ''}\n{kind}" for index, kind in enumerate(_FAILED))
    headers = (*_SCORES, *(f"{header}\n%" for header in failed))
    table = _make(title, who, headers)
    for row in ranked(rows):
        summary = row.summary
        numbers = (*_score(row), f"{summary.interquartile_mean.value:.3f}", f"{summary.worst_twentieth:.3f}")
        skill = _ABSENT if row.floor else _three_decimals(summary.skill(floor))
        table.add_row(row.name, *numbers, skill, *map(_share, summary.failure.tolist()))
    return table


def ranked(rows: Iterable[Row]) -> list[Row]:
    """The rows by their mean score, best first; the floors after all others."""
    return sorted(rows, key=lambda row: (row.floor, -row.score.value))


def best_floor(rows: Iterable[Row]) -> float:
    """The highest mean score of the floors [1]; NaN without one."""
    return max((row.score.value for row in rows if row.floor), default=math.nan)


def _make(title: str, who: str, headers: Iterable[str]) -> Table:
    table = Table(title=title, title_justify="left", box=SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))
    table.add_column(who, no_wrap=True, vertical="bottom")
    for header in headers:
        table.add_column(header, justify="right", no_wrap=True, vertical="bottom")
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


def _three_decimals(value: float) -> str:
    return _ABSENT if math.isnan(value) else f"{value:.3f}"


def _share(value: float) -> str:
    """A percentage without decimals."""
    return _ABSENT if math.isnan(value) else f"{value:.0f}"


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
