"""Aggregates over episodes: they do not know who produced the scores."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from prp_gym.checks import LARGEST, as_array
from prp_gym.errors import InvalidValueError, ShapeError
from prp_gym.evaluation.resampling import RESAMPLES, check_bootstrap, check_scores, cut_tails
from prp_gym.robot.arrays import Array


class Estimate(NamedTuple):
    """A point estimate with a confidence interval."""

    value: float
    low: float
    high: float


def interquartile_mean(values: Array) -> Array:
    """Mean of the middle half, (..., n) -> (...): a quarter of n, rounded down, is cut off at each end.

    NaN, an undefined metric, gives NaN; infinity, a time that was never reached, may be cut off.

    Raises:
        InvalidValueError: values that are not numbers, or finite ones so large that their sum overflows.
        ShapeError: no values.

    Source: Agarwal 2021.
    """
    values = as_array("values", values)
    if values.ndim == 0 or values.shape[-1] == 0:
        raise ShapeError("values", values.shape, "(..., n), n at least 1")
    finite = values[np.isfinite(values)]
    if np.abs(finite).max(initial=0.0) > LARGEST:
        raise InvalidValueError("values", values, f"magnitudes up to {LARGEST:g}, or infinity")
    ordered = np.sort(values, axis=-1)
    cut = values.shape[-1] // 4
    middle: Array = ordered[..., cut : values.shape[-1] - cut].mean(axis=-1)
    return middle


def bootstrap_interquartile_mean(
    values: Array, rng: np.random.Generator, confidence: float = 0.95, resamples: int = RESAMPLES
) -> Estimate:
    """Interquartile mean with a percentile bootstrap interval over the episodes.

    Args:
        values: one value for each episode, (n).
        rng: random generator of the resampling.
        confidence: confidence level of the interval, between 0 and 1.
        resamples: number of bootstrap resamples.

    Returns:
        the estimate; without spread, or of one episode, the interval is the point.

    Raises:
        InvalidValueError: no values, no resamples, or a confidence outside (0, 1).
        ShapeError: values that are not in one row.
        NonFiniteError: NaN or infinity among the values.
    """
    return _bootstrap(interquartile_mean, values, rng, confidence, resamples)


def bootstrap_mean(
    values: Array, rng: np.random.Generator, confidence: float = 0.95, resamples: int = RESAMPLES
) -> Estimate:
    """Mean with a percentile bootstrap interval over the episodes.

    Args:
        values: one value for each episode, (n).
        rng: random generator of the resampling.
        confidence: confidence level of the interval, between 0 and 1.
        resamples: number of bootstrap resamples.

    Returns:
        the estimate; without spread, or of one episode, the interval is the point.

    Raises:
        InvalidValueError: no values, no resamples, or a confidence outside (0, 1).
        ShapeError: values that are not in one row.
        NonFiniteError: NaN or infinity among the values.
    """
    return _bootstrap(mean, values, rng, confidence, resamples)


def mean(values: Array) -> Array:
    """Mean over the last axis, (..., n) -> (...)."""
    found: Array = values.mean(axis=-1)
    return found


def worst_twentieth(values: Array) -> float:
    """Mean of the worst 5 % of the values (n), rounded down to whole values, of one at least.

    Source: the conditional value at risk at 5 %.
    """
    ordered = np.sort(values, axis=None)
    return float(ordered[: max(1, ordered.size // 20)].mean())


def _bootstrap(
    statistic: Callable[[Array], Array],
    values: Array,
    rng: np.random.Generator,
    confidence: float,
    resamples: int,
) -> Estimate:
    """A statistic of the last axis with a percentile interval over the values (n)."""
    check_bootstrap(confidence, resamples, rng)
    values = check_scores(values, "values", ("n",))
    drawn = rng.choice(values, size=(resamples, len(values)), replace=True)
    low, high = cut_tails(statistic(drawn), confidence)
    return Estimate(float(statistic(values)), float(low), float(high))
