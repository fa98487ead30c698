"""Probability of improvement: how often one policy is better than another."""

import numpy as np

from prp_gym.errors import ShapeError
from prp_gym.evaluation.resampling import (
    RESAMPLES,
    Counts,
    Runs,
    accumulate,
    check_bootstrap,
    check_runs,
    check_same_tasks,
    cut_tails,
    draw_counts,
    split_resamples,
)
from prp_gym.evaluation.statistics import Estimate
from prp_gym.robot.arrays import Array


def probability_of_improvement(
    x: Runs, y: Runs, rng: np.random.Generator, confidence: float = 0.95, resamples: int = RESAMPLES
) -> Estimate:
    """P(X > Y) + ½ P(X = Y), averaged over tasks, with an interval of a stratified bootstrap.

    On a task it is U / (N M), U being the Mann-Whitney statistic of N runs of x against M of y: any run of
    the one is compared with any of the other. The bootstrap draws the runs of x and those of y
    independently of each other, within each task. Runs are taken as independent of one another; where both
    policies were evaluated on the same seeds, see `paired_probability_of_improvement`.

    Args:
        x: one array (N) [1] for each task.
        y: one array (M) [1] for each of the same tasks; M may differ from N.
        rng: random generator of the resampling.
        confidence: confidence level of the interval, between 0 and 1.
        resamples: number of bootstrap resamples.

    Returns:
        the estimate [1]; ½ says that neither is better.

    Raises:
        InvalidValueError: no tasks or runs, different tasks, no resamples, or a confidence outside (0, 1).
        ShapeError: runs of a task that are not in one row.
        NonFiniteError: NaN or infinity among the runs.

    Source: Agarwal 2021, Mann 1947.
    """
    check_bootstrap(confidence, resamples, rng)
    tasks, others = check_runs(x, "x"), check_runs(y, "y")
    check_same_tasks(tasks, others)
    value = 0.0
    drawn = np.zeros(resamples)
    for task, runs in tasks.items():
        ordered, other = np.sort(runs), np.sort(others[task])
        ones = np.ones(len(ordered), dtype=np.int64), np.ones(len(other), dtype=np.int64)
        value += float(_compare(ordered, other, *ones))
        drawn += _draw_comparisons(ordered, other, resamples, rng)
    return _average(value, drawn, len(tasks), confidence)


def paired_probability_of_improvement(
    x: Runs, y: Runs, rng: np.random.Generator, confidence: float = 0.95, resamples: int = RESAMPLES
) -> Estimate:
    """Share of evaluation seeds on which x is better than y, ties counting ½, averaged over tasks.

    Run n of x is compared with run n of y alone, and the bootstrap draws evaluation seeds within each task,
    the same ones for both policies. The common effect of a seed on both thus cancels; in general
    the number differs from that of `probability_of_improvement`, which compares across seeds.

    Args:
        x: one array (N) [1] for each task, one run an evaluation seed.
        y: the same for the other policy, on the same evaluation seeds in the same order.
        rng: random generator of the resampling.
        confidence: confidence level of the interval, between 0 and 1.
        resamples: number of bootstrap resamples.

    Returns:
        the estimate [1]; ½ says that neither is better.

    Raises:
        InvalidValueError: no tasks or runs, different tasks, no resamples, or a confidence outside (0, 1).
        ShapeError: runs of a task that are not in one row, or not as many of y as of x.
        NonFiniteError: NaN or infinity among the runs.

    Source: Agarwal 2021.
    """
    check_bootstrap(confidence, resamples, rng)
    tasks, others = check_runs(x, "x"), check_runs(y, "y")
    check_same_tasks(tasks, others)
    value = 0.0
    drawn = np.zeros(resamples)
    for task, runs in tasks.items():
        if others[task].shape != runs.shape:
            raise ShapeError(f"y of task {task!r}", others[task].shape, f"{runs.shape}, as x")
        wins = np.sort((1.0 + np.sign(runs - others[task])) / 2)
        value += float(wins.mean())
        drawn += _draw_means(wins, resamples, rng)
    return _average(value, drawn, len(tasks), confidence)


def _compare(x: Array, y: Array, counts_x: Counts, counts_y: Counts) -> Array:
    """U / (N M) of sorted x (N) and y (M), each run as often as it counts: (..., N), (..., M) -> (...)."""
    total = accumulate(counts_y)
    smaller = total[..., np.searchsorted(y, x, side="left")]
    not_larger = total[..., np.searchsorted(y, x, side="right")]
    share: Array = (counts_x * (smaller + not_larger)).sum(axis=-1) / (2 * len(x) * len(y))
    return share


def _draw_comparisons(x: Array, y: Array, resamples: int, rng: np.random.Generator) -> Array:
    parts = [
        _compare(x, y, draw_counts(size, len(x), rng), draw_counts(size, len(y), rng))
        for size in split_resamples(resamples, len(x) + len(y))
    ]
    shares: Array = np.concatenate(parts)
    return shares


def _draw_means(values: Array, resamples: int, rng: np.random.Generator) -> Array:
    sizes = split_resamples(resamples, len(values))
    means: Array = np.concatenate([draw_counts(size, len(values), rng) @ values for size in sizes])
    return means / len(values)


def _average(value: float, drawn: Array, tasks: int, confidence: float) -> Estimate:
    """Estimate of a mean over tasks from the sums over them."""
    low, high = cut_tails(drawn / tasks, confidence)
    return Estimate(value / tasks, float(low), float(high))
