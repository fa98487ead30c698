"""The intervals of a plan: as long as the control period at first, then longer and longer."""

import numpy as np

from prp_gym.baselines.predictive.formulas import KNOTS
from prp_gym.robot.arrays import Array

_BISECTIONS = 60


def interval_durations(period: float, horizon: float) -> Array:
    """Durations h_k = h rᵏ (N, 1) of the intervals, r ≥ 1, that end together with the horizon.

    Args:
        period: control period h [s].
        horizon: duration of the plan [s]; at least N control periods, which a shorter one stands for.
    """
    low, high = 1.0, max(horizon / period, 1.0)
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _sum_of_powers(middle) * period < horizon else (low, middle)
    return period * _powers(low)[:, None]


def shifted(plan: Array, duration: Array) -> Array:
    """A plan (M, N, n) a control period later: each interval takes the mean of what it then covers.

    The last interval holds its value.

    Args:
        plan: one vector for each interval.
        duration: durations (N, 1) of the intervals, of which the first is the control period [s].
    """
    following = np.concatenate([plan[:, 1:], plan[:, -1:]], axis=1)
    share = duration[0] / duration
    later: Array = (1.0 - share) * plan + share * following
    return later


def _powers(ratio: float) -> Array:
    """rᵏ (N)."""
    return np.cumprod(np.concatenate([[1.0], np.full(KNOTS - 1, ratio)]))


def _sum_of_powers(ratio: float) -> float:
    return float(sum(_powers(ratio).tolist()))
