"""Evaluations as a table for the terminal."""

import math
from collections.abc import Sequence
from typing import NamedTuple

from rich.box import SIMPLE_HEAD
from rich.table import Table

from prp_gym.evaluation.evaluate import Evaluation
from prp_gym.robot.arrays import Array

_ABSENT = "-"
_SMALLEST = 1e-6
_HEADERS = (
    "score",
    "95 % interv.",
    "joint RMSE\nrad, m, rad",
    "steady error\nrad, m, rad",
    "settles\ns",
    "over-\nshoot %",
    "energy\nJ",
    "sat.\n%",
    "µs per\naction",
)


class Row(NamedTuple):
    """One line of the table."""

    baseline: str
    evaluation: Evaluation


def _number(value: float, digits: int = 2) -> str:
    if math.isnan(value):
        return _ABSENT
    if math.isinf(value):
        return "never"
    return "0" if abs(value) < _SMALLEST else f"{value:.{digits}g}"


def _vector(values: Array | None) -> str:
    if values is None or all(math.isnan(value) for value in values):
        return _ABSENT
    return " ".join(_number(value) for value in values.tolist())


def evaluation_table(title: str, rows: Sequence[Row]) -> Table:
    """Scores and medians over the episodes, best score first.

    Args:
        title: what was evaluated.
        rows: of one environment and scenario.

    Returns:
        a table for a terminal of 120 columns. Vectors are the three joints [rad, m, rad]; what is
        smaller than 1e-6 in its unit is shown as 0.
    """
    table = Table(title=title, title_justify="left", box=SIMPLE_HEAD, pad_edge=False)
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
        _number(float(median["energy"][0]), 3),
        _number(float(median["saturation"][0])),
        f"{1e6 * row.evaluation.compute_time:.0f}",
    ]
