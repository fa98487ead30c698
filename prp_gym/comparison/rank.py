"""Rank correlations, of values and of resampled ones."""

import numpy as np
from numpy.typing import NDArray

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


def concordance(x: Array, y: Array, counted: NDArray[np.bool_] | None = None) -> float:
    """Goodman and Kruskal's γ, the rank correlation over every two values that both x and y distinguish.

    γ = (C - D)/(C + D) with C cases of two that x and y rank alike and D that they rank oppositely. Unlike
    Spearman's correlation it can reach 1 where many values are equal.

    Args:
        x: (n), infinite values allowed.
        y: (n), likewise.
        counted: (n, n), symmetric, whether each case of two counts; None counts all.

    Returns:
        γ in [-1, 1]; NaN where no two are distinguished.

    Raises:
        ShapeError: not as many values of y as of x.

    Source: Goodman and Kruskal 1954.
    """
    if np.shape(x) != np.shape(y):
        raise ShapeError("y", np.shape(y), f"{np.shape(x)}, as x")
    first, second = (average_ranks(values) for values in (x, y))
    agreement = np.sign(first[:, None] - first) * np.sign(second[:, None] - second)
    if counted is not None:
        agreement *= counted
    distinguished = np.count_nonzero(agreement)
    return float(agreement.sum() / distinguished) if distinguished else float("nan")


def resampled_concordances(x: Array, y: Array, counted: NDArray[np.bool_] | None = None) -> Array:
    """γ of every resample.

    Args:
        x: (resamples, n), infinite values allowed.
        y: (resamples, n), likewise.
        counted: (n, n), symmetric, whether each case of two counts; None counts all.

    Returns:
        (resamples), without those in which no two are distinguished.
    """
    found = np.array([concordance(first, second, counted) for first, second in zip(x, y, strict=True)])
    defined: Array = found[~np.isnan(found)]
    return defined


def distinguished(values: Array, errors: float) -> NDArray[np.bool_]:
    """Whether the means of every two rows differ by more than chance, compared sample by sample.

    Args:
        values: (n, samples), finite or NaN; the samples of all rows were taken under equal conditions. NaN
            is left out.
        errors: standard errors of the mean difference by which two rows have to differ [1].

    Returns:
        (n, n); with a single sample, whether the two differ at all.
    """
    difference = values[:, None] - values
    count = np.count_nonzero(~np.isnan(difference), axis=-1)
    mean = np.nansum(difference, axis=-1) / np.maximum(count, 1)
    spread = np.nansum((difference - mean[..., None]) ** 2, axis=-1) / np.maximum(count - 1, 1)
    found: NDArray[np.bool_] = np.abs(mean) > errors * np.sqrt(spread / np.maximum(count, 1))
    return found
