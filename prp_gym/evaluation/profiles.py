"""Performance profiles: the share of runs above each score."""

from typing import NamedTuple

import numpy as np

from prp_gym.checks import whole
from prp_gym.evaluation.resampling import (
    RESAMPLES,
    Indices,
    Runs,
    accumulate,
    check_bootstrap,
    check_runs,
    check_scores,
    cut_tails,
    draw_counts,
    split_resamples,
)
from prp_gym.robot.arrays import Array

_MOST_NUMBERS = 10**8  # of a profile's resamples; bounds the memory


class Profile(NamedTuple):
    """Share of runs above each threshold (K) [1], with a confidence interval at each of them."""

    thresholds: Array
    value: Array
    low: Array
    high: Array


def performance_profile(
    scores: Runs,
    thresholds: Array,
    rng: np.random.Generator,
    confidence: float = 0.95,
    resamples: int = RESAMPLES,
) -> Profile:
    """Share of runs with score > τ for each threshold τ, with percentile bands of a stratified bootstrap.

    The share is F(τ) = 1/T Σ_t 1/N_t #{n: score_tn > τ}: each of T tasks has the same weight, whatever
    its number of runs N_t. The bootstrap draws the runs within each task and keeps the tasks. The band is
    pointwise: it has the confidence at each threshold, not at all of them together. Runs are taken as
    independent of one another.

    Args:
        scores: one array (N_t) [1] for each task.
        thresholds: τ (K) [1], in any order.
        rng: random generator of the resampling.
        confidence: confidence level of the band, between 0 and 1.
        resamples: number of bootstrap resamples; the memory grows with this number times K.

    Returns:
        the profile; where a task has one run, that task adds no width to the band.

    Raises:
        InvalidValueError: no tasks, runs or thresholds, no resamples, or a confidence outside (0, 1).
        ShapeError: runs of a task, or thresholds, that are not in one row.
        NonFiniteError: NaN or infinity among runs or thresholds.

    Source: Agarwal 2021, Dolan 2002.
    """
    check_bootstrap(confidence, resamples, rng)
    tasks = check_runs(scores)
    levels = check_scores(thresholds, "thresholds", ("K",))
    whole("number of resamples times thresholds", resamples * len(levels), 1, _MOST_NUMBERS)
    value = np.zeros(len(levels))
    drawn = np.zeros((resamples, len(levels)))
    for runs in tasks.values():
        ordered = np.sort(runs)
        below = np.searchsorted(ordered, levels, side="right")
        value += (len(runs) - below) / len(runs)
        drawn += _draw_shares(below, len(runs), resamples, rng)
    low, high = cut_tails(drawn / len(tasks), confidence)
    return Profile(levels, value / len(tasks), low, high)


def _draw_shares(below: Indices, runs: int, resamples: int, rng: np.random.Generator) -> Array:
    """Shares above K thresholds in resamples of sorted runs, of which the first `below` (K) are not."""
    parts = [
        (runs - accumulate(draw_counts(size, runs, rng))[:, below]) / runs
        for size in split_resamples(resamples, runs)
    ]
    shares: Array = np.concatenate(parts)
    return shares
