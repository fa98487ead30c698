"""Rank correlation, of values and of resampled ones."""

import numpy as np

from prp_gym.errors import ShapeError
from prp_gym.robot.arrays import Array


def average_ranks(values: Array) -> Array:
    """Ranks from 0, equal values sharing the mean of theirs: (n) -> (n)."""
    _, index, counts = np.unique(values, return_inverse=True, return_counts=True)
    last = np.cumsum(counts) - 1
    ranks: Array = (last - (counts - 1) / 2.0)[index]
    return ranks


def rank_correlation(x: Array, y: Array) -> float:
    """Spearman's rank correlation, ties having average ranks; NaN where all of x or all of y are equal.

    Args:
        x: (n), infinite values allowed.
        y: (n), likewise.

    Raises:
        ShapeError: not as many values of y as of x.

    Source: Spearman 1904.
    """
    if np.shape(x) != np.shape(y):
        raise ShapeError("y", np.shape(y), f"{np.shape(x)}, as x")
    first, second = (average_ranks(values) - (len(values) - 1) / 2.0 for values in (x, y))
    norm = np.sqrt((first @ first) * (second @ second))
    return float(first @ second / norm) if norm > 0.0 else float("nan")


def resampled_correlations(x: Array, y: Array) -> Array:
    """Rank correlation of every resample.

    Args:
        x: (resamples, n), infinite values allowed.
        y: (resamples, n), likewise.

    Returns:
        (resamples), without those in which all of x or all of y are equal.
    """
    found = np.array([rank_correlation(first, second) for first, second in zip(x, y, strict=True)])
    defined: Array = found[~np.isnan(found)]
    return defined
