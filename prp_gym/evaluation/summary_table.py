"""`summary_table`: an evaluation in a few lines, for notebooks."""

import math
from collections.abc import Iterator, Mapping

from prp_gym.evaluation.column import Column
from prp_gym.evaluation.failure import FAILURES
from prp_gym.evaluation.metrics import METRICS
from prp_gym.evaluation.score_summary import ScoreSummary
from prp_gym.evaluation.scoring import scoring_of
from prp_gym.robot.arrays import Array
from prp_gym.tables import ABSENT, Cell, ResultTable, TableColumn
from prp_gym.tables.column import text_column
from prp_gym.tables.headings import without_breaks

_COLUMNS = (text_column("quantity"), TableColumn("value"), text_column("unit"))
_DIGITS = ".4g"


def summary_table(
    title: str, environment_id: str, summary: ScoreSummary, median: Mapping[str, Array]
) -> ResultTable:
    """Score, failures, and the medians of some metrics, one line each.

    Args:
        title: what was evaluated.
        environment_id: id of the environment, whose task declares the metrics to show.
        summary: scores and failures.
        median: medians of the metrics over the episodes (components).
    """
    metrics = [name for name in scoring_of(environment_id).columns if name in median]
    rows = [*_scores(summary), *(_metric(name, median[name]) for name in metrics)]
    return ResultTable.of(title, _COLUMNS, rows)


def _scores(summary: ScoreSummary) -> Iterator[tuple[Cell | str, ...]]:
    mean = summary.mean
    yield "score", Cell(f"{mean.value:.3f}", mean.value), "1"
    yield "score, 95 % interval", Cell(f"{mean.low:.3f}-{mean.high:.3f}", (mean.low, mean.high)), "1"
    yield "score, interquartile mean", Cell.number(summary.interquartile_mean.value), "1"
    yield "score of the worst twentieth", Cell.number(summary.worst_twentieth), "1"
    for kind, share in zip(FAILURES, summary.failure.tolist(), strict=True):
        yield f"failed: {kind}", Cell.number(share, ".0f"), "%"


def _metric(name: str, values: Array) -> tuple[Cell | str, ...]:
    """The median of a metric under its heading and in the units of tables."""
    column = METRICS.find(name).column
    shown = Column(name, METRICS.find(name).units) if column is None else column
    numbers = (shown.scale * values).tolist()
    value = Cell(" ".join(map(_number, numbers)), tuple(numbers))
    unit = ", ".join(dict.fromkeys(shown.units[: len(numbers)]))
    return f"median {without_breaks(shown.title)}", ABSENT if all(map(math.isnan, numbers)) else value, unit


def _number(value: float) -> str:
    return "never" if math.isinf(value) else format(value, _DIGITS)
