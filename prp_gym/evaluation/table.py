"""Evaluations as tables, with the columns that the task declares."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Self

from prp_gym.artifacts import to_array
from prp_gym.errors import InvalidValueError
from prp_gym.evaluation.column import Column
from prp_gym.evaluation.metrics import METRICS
from prp_gym.evaluation.score_summary import ScoreSummary
from prp_gym.evaluation.statistics import Estimate
from prp_gym.robot.arrays import Array
from prp_gym.tables import ABSENT, Cell, ResultTable, TableColumn
from prp_gym.tables.column import interval_column, text_column

SCORE_NOTE = (
    "worst twentieth: mean of the worst 5 % of the episodes, of one at least; skill: share of what lies "
    "between the best floor and 1; failed: share of episodes, each counted once. Other figures are medians."
)
"""Explanation of the columns of `score_table`, and of the other figures."""

_WIDEST_NAME = 28  # with it the widest table of an evaluation holds in 120 columns
_SCORE = (TableColumn("score"), interval_column("95 % interval"))
_SCORES = (
    *_SCORE,
    TableColumn("inter\u00adquartile mean"),
    TableColumn("worst twen\u00adtieth"),
    TableColumn("skill above best floor"),
)
_FAILED = tuple(
    TableColumn(f"failed: {kind}", ("%",))  # in the order of `FAILURES`
    for kind in ("di\u00adverged", "excess force", "limit cycle", "un\u00adset\u00adtled")
)
_TIME = TableColumn("com\u00adpute time per step", ("µs",))
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

    def heading(self, rows: Sequence[Row]) -> TableColumn:
        """Heading with units, those of as many components as the rows have."""
        medians = (row.median for row in rows)
        count = max(len(median[self.metric]) for median in medians if self.metric in median)
        parts = tuple(str(index + 1) for index in range(count)) if count > 1 else ()
        return TableColumn(self.column.title.replace("\n", " "), self.column.units[:count], parts=parts)

    def cell(self, row: Row) -> Cell:
        """The median of one row."""
        values = row.median.get(self.metric)
        return ABSENT if values is None else _vector(self.column.scale * values)


def evaluation_table(
    title: str, rows: Sequence[Row], metrics: Iterable[str], who: str = "controller"
) -> ResultTable:
    """Mean scores and medians of the metrics, best score first and the floors last.

    Args:
        title: what was evaluated.
        rows: rows of one environment and scenario.
        metrics: metrics whose medians are shown, as the task declares them; those that no row has are left
            out.
        who: header of the names of the rows.

    Returns:
        a table that fits a terminal of 120 columns. Vectors are the joints [mrad, mm, mrad]; what is below
        0.005 is shown as 0.

    Raises:
        UnknownNameError: a metric that does not exist.
        InvalidValueError: a metric without a column.
    """
    columns = _columns(metrics, rows)
    headings = (text_column(who, _WIDEST_NAME), *_SCORE, *(column.heading(rows) for column in columns), _TIME)
    lines = [
        (Cell.of(row.name), *_score(row), *(column.cell(row) for column in columns), _time(row))
        for row in ranked(rows)
    ]
    return ResultTable.of(title, headings, lines)


def score_table(title: str, rows: Sequence[Row], who: str = "controller") -> ResultTable:
    """Scores, what their mean hides, and the failed episodes by kind; best first and the floors last.

    Args:
        title: what was evaluated.
        rows: rows of one environment and scenario.
        who: header of the names of the rows.
    """
    headings = (text_column(who, _WIDEST_NAME), *_SCORES, *_FAILED)
    floor = best_floor(rows)
    return ResultTable.of(title, headings, [_scores(row, floor) for row in ranked(rows)])


def _scores(row: Row, floor: float) -> tuple[Cell, ...]:
    """One line of the scores, with the skill above the score of the best floor."""
    summary = row.summary
    return (
        Cell.of(row.name),
        *_score(row),
        Cell.number(summary.interquartile_mean.value),
        Cell.number(summary.worst_twentieth),
        ABSENT if row.floor else Cell.number(summary.skill(floor)),
        *(Cell.number(share, ".0f") for share in summary.failure.tolist()),
    )


def ranked(rows: Iterable[Row]) -> list[Row]:
    """The rows by their mean score, best first; the floors after all others."""
    return sorted(rows, key=lambda row: (row.floor, -row.score.value))


def best_floor(rows: Iterable[Row]) -> float:
    """The highest mean score of the floors [1]; NaN without one."""
    return max((row.score.value for row in rows if row.floor), default=math.nan)


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


def _score(row: Row) -> tuple[Cell, Cell]:
    score = row.score
    interval = f"{score.low:.3f}-{score.high:.3f}" if row.episodes > 1 else "1 episode"
    return Cell.number(score.value), Cell(interval, (score.low, score.high))


def _time(row: Row) -> Cell:
    microseconds = 1e6 * row.compute_time
    return Cell(_number(round(microseconds)), microseconds)


def _vector(values: Array) -> Cell:
    numbers = values.tolist()
    if all(math.isnan(value) for value in numbers):
        return ABSENT
    text = " ".join(_number(value) for value in numbers)
    return Cell(text, tuple(numbers) if len(numbers) > 1 else numbers[0])


def _number(value: float) -> str:
    """In at most four characters and a sign, or as a word."""
    if math.isnan(value):
        return ABSENT.text
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
