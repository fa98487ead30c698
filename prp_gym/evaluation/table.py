"""Evaluations as a table for the terminal."""

import math
from collections.abc import Sequence
from typing import NamedTuple

from rich.box import SIMPLE_HEAD
from rich.table import Table

from prp_gym.evaluation.evaluate import Evaluation
from prp_gym.robot.arrays import Array

_ABSENT = "-"
_SMALLEST = 0.005
_TWO_DECIMALS_BELOW = 0.1
_WHOLE_FROM = 10.0
_HEADERS = (
    "score",
    "95 % interval",
    "joint RMSE\nmrad mm mrad",
    "steady error\nmrad mm mrad",
    "settle\ns",
    "over-\nsh. %",
    "energy\nJ",
    "sat.\n%",
    "law\nµs",
)


class Row(NamedTuple):
    """One line of the table."""

    baseline: str
    evaluation: Evaluation


def _number(value: float) -> str:
    if math.isnan(value):
        return _ABSENT
    if math.isinf(value):
        return "never"
    if abs(value) < _SMALLEST:
        return "0"
    if abs(value) < _TWO_DECIMALS_BELOW:
        return f"{value:.2f}"
    return f"{value:.0f}" if abs(value) >= _WHOLE_FROM else f"{value:.2g}"


def _vector(values: Array | None) -> str:
    if values is None or all(math.isnan(value) for value in values):
        return _ABSENT
    return " ".join(_number(1e3 * value) for value in values.tolist())


def evaluation_table(title: str, rows: Sequence[Row]) -> Table:
    """Scores and medians over the episodes, best score first.

    Args:
        title: what was evaluated.
        rows: of one environment and scenario.

    Returns:
        a table for a terminal of 120 columns. Vectors are the three joints [mrad, mm, mrad]; what
        is below 0.005 is shown as 0.
    """
    table = Table(title=title, title_justify="left", box=SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))
    table.add_column("law", no_wrap=True)
    for header in _HEADERS:
        table.add_column(header, justify="right", no_wrap=True)
    for row in sorted(rows, key=lambda row: -row.evaluation.score.value):
        table.add_row(*_cells(row))
    return table


def _cells(row: Row) -> list[str]:
    score, median = row.evaluation.score, row.evaluation.median
    nothing = [math.nan]
    return [
        row.baseline,
        f"{score.value:.3f}",
        f"{score.low:.3f}-{score.high:.3f}" if len(row.evaluation.rollouts) > 1 else "1 episode",
        _vector(median.get("joint_rmse")),
        _vector(median.get("steady_state_error")),
        *(_number(float(median.get(name, nothing)[0])) for name in ("settling_time", "overshoot")),
        _number(float(median["energy"][0])),
        _number(float(median["saturation"][0])),
        f"{1e6 * row.evaluation.compute_time:.0f}",
    ]
