"""Means and interquartile means of trained agents: scores spread over training seeds and over episodes.

Scores are (training seeds, episodes). A controller that is not trained has one row: a level with one member
adds no spread, so that its interval is over episodes only and says nothing about training. With few training
seeds the intervals are too narrow: where the spread over training seeds dominates, 95 % intervals of 3, 5, 10
or 20 of them cover the true value in about 75, 85, 90 or 93 % of all cases.
"""

from collections.abc import Callable, Mapping

import numpy as np

from prp_gym.errors import InvalidValueError, ShapeError
from prp_gym.evaluation.resampling import (
    RESAMPLES,
    Indices,
    Runs,
    check_bootstrap,
    check_scores,
    cut_tails,
    split_resamples,
)
from prp_gym.evaluation.statistics import Estimate, interquartile_mean
from prp_gym.robot.arrays import Array

Statistic = Callable[[Array], Array]
"""An aggregate over the last axis, (..., n) -> (...)."""

_AXES = ("training seeds", "episodes")


def bootstrap_nested(
    scores: Array,
    rng: np.random.Generator,
    confidence: float = 0.95,
    resamples: int = RESAMPLES,
    statistic: Statistic = interquartile_mean,
) -> Estimate:
    """A statistic of all scores, its interval over training seeds and episodes of their own.

    A resample draws training seeds, then episodes of each drawn seed, once for every time that it was drawn.
    The interval is meant for episodes that differ from one training seed to the next; where all agents were
    evaluated on the same evaluation seeds, `bootstrap_crossed` keeps what those seeds have in common. If
    training seeds differ no more than their episodes explain, the interval is up to √2 times too wide.

    Args:
        scores: (training seeds, episodes) [1].
        rng: random generator of the resampling.
        confidence: confidence level of the interval, between 0 and 1.
        resamples: number of bootstrap resamples.
        statistic: aggregate over the last axis, (..., n) -> (...).

    Returns:
        the estimate [1]; with one training seed only episodes are drawn.

    Raises:
        InvalidValueError: no scores, no resamples, or a confidence outside (0, 1).
        ShapeError: scores of other than two axes.
        NonFiniteError: NaN or infinity among the scores.

    Source: Agarwal 2021, Davison 1997.
    """

    def draw(checked: Array, size: int) -> Array:
        return _draw_nested(checked, size, rng, statistic)

    return _bootstrap(scores, draw, rng, confidence, resamples, statistic)


def bootstrap_crossed(
    scores: Array,
    rng: np.random.Generator,
    confidence: float = 0.95,
    resamples: int = RESAMPLES,
    statistic: Statistic = interquartile_mean,
) -> Estimate:
    """A statistic of all scores, its interval over training seeds and common evaluation seeds.

    A resample draws training seeds, and evaluation seeds once for all of them: an evaluation seed that is
    hard for every agent is then as rare or as frequent for all.

    Args:
        scores: (training seeds, evaluation seeds) [1], a column for each evaluation seed.
        rng: random generator of the resampling.
        confidence: confidence level of the interval, between 0 and 1.
        resamples: number of bootstrap resamples.
        statistic: aggregate over the last axis, (..., n) -> (...).

    Returns:
        the estimate [1]; with one training seed only episodes are drawn.

    Raises:
        InvalidValueError: no scores, no resamples, or a confidence outside (0, 1).
        ShapeError: scores of other than two axes.
        NonFiniteError: NaN or infinity among the scores.

    Source: Agarwal 2021, Owen 2007.
    """

    def draw(checked: Array, size: int) -> Array:
        return _draw_crossed(checked, _draw(size, checked.shape[1], rng), rng, statistic)

    return _bootstrap(scores, draw, rng, confidence, resamples, statistic)


def bootstrap_difference(
    x: Array,
    y: Array,
    rng: np.random.Generator,
    confidence: float = 0.95,
    resamples: int = RESAMPLES,
    statistic: Statistic = interquartile_mean,
) -> Estimate:
    """A statistic of x less that of y, two policies on the same evaluation seeds, with an interval.

    A resample draws evaluation seeds once for both policies, and training seeds of x and of y apart from
    each other: the common effect of an evaluation seed on both cancels in the difference.

    Args:
        x: (training seeds of x, evaluation seeds) [1], a column for each evaluation seed.
        y: (training seeds of y, evaluation seeds) [1], the same evaluation seeds in the same order.
        rng: random generator of the resampling.
        confidence: confidence level of the interval, between 0 and 1.
        resamples: number of bootstrap resamples.
        statistic: aggregate over the last axis, (..., n) -> (...).

    Returns:
        the estimate [1]; an interval above 0 says that x is better.

    Raises:
        InvalidValueError: no scores, no resamples, or a confidence outside (0, 1).
        ShapeError: scores of other than two axes, or not as many evaluation seeds of y as of x.
        NonFiniteError: NaN or infinity among the scores.

    Source: Agarwal 2021, Owen 2007.
    """
    check_bootstrap(confidence, resamples, rng)
    ours, theirs = check_scores(x, "scores x", _AXES), check_scores(y, "scores y", _AXES)
    if theirs.shape[1] != ours.shape[1]:
        raise ShapeError("scores y", theirs.shape, f"(training seeds, {ours.shape[1]}), as x")
    drawn = []
    for size in split_resamples(resamples, ours.size + theirs.size):
        columns = _draw(size, ours.shape[1], rng)
        parts = (_draw_crossed(own, columns, rng, statistic) for own in (ours, theirs))
        drawn.append(next(parts) - next(parts))
    value = float(_pool(ours, statistic) - _pool(theirs, statistic))
    return _estimate(value, np.concatenate(drawn), confidence)


def bootstrap_tasks(
    scores: Runs,
    rng: np.random.Generator,
    confidence: float = 0.95,
    resamples: int = RESAMPLES,
    statistic: Statistic = interquartile_mean,
) -> Estimate:
    """A statistic over tasks of the same statistic on each, with an interval.

    Each task weighs the same, whatever its number of scores. A resample draws training seeds and evaluation
    seeds of each task as `bootstrap_crossed` does, and keeps the tasks.

    Args:
        scores: (training seeds, evaluation seeds) [1] for each task.
        rng: random generator of the resampling.
        confidence: confidence level of the interval, between 0 and 1.
        resamples: number of bootstrap resamples.
        statistic: aggregate over the last axis, (..., n) -> (...).

    Returns:
        the estimate [1].

    Raises:
        InvalidValueError: no tasks or scores, no resamples, or a confidence outside (0, 1).
        ShapeError: scores of other than two axes.
        NonFiniteError: NaN or infinity among the scores.

    Source: Agarwal 2021, Owen 2007.
    """
    check_bootstrap(confidence, resamples, rng)
    if not isinstance(scores, Mapping) or not all(isinstance(task, str) for task in scores):
        raise InvalidValueError("scores", scores, "a mapping from the names of tasks to their scores")
    if not scores:
        raise InvalidValueError("number of tasks", 0, "at least 1")
    values, drawn = [], []
    for task in sorted(scores):
        checked = check_scores(scores[task], f"scores of task {task!r}", _AXES)
        parts = [
            _draw_crossed(checked, _draw(size, checked.shape[1], rng), rng, statistic)
            for size in split_resamples(resamples, checked.size)
        ]
        values.append(_pool(checked, statistic))
        drawn.append(np.concatenate(parts))
    together = statistic(np.stack(drawn, axis=-1))
    return _estimate(float(statistic(np.array(values))), together, confidence)


def _bootstrap(
    scores: Array,
    draw: Callable[[Array, int], Array],
    rng: np.random.Generator,
    confidence: float,
    resamples: int,
    statistic: Statistic,
) -> Estimate:
    """A statistic of all scores, with an interval from resamples that are drawn block by block."""
    check_bootstrap(confidence, resamples, rng)
    checked = check_scores(scores, "scores", _AXES)
    drawn = [draw(checked, size) for size in split_resamples(resamples, checked.size)]
    return _estimate(float(_pool(checked, statistic)), np.concatenate(drawn), confidence)


def _pool(scores: Array, statistic: Statistic) -> Array:
    """A statistic over both levels together: (..., training seeds, episodes) -> (...)."""
    return statistic(scores.reshape(*scores.shape[:-2], -1))


def _draw(resamples: int, members: int, rng: np.random.Generator) -> Indices:
    """Members drawn with replacement, as many as there are: (resamples, members)."""
    return rng.integers(members, size=(resamples, members))


def _draw_nested(scores: Array, resamples: int, rng: np.random.Generator, statistic: Statistic) -> Array:
    rows = _draw(resamples, len(scores), rng)
    columns = rng.integers(scores.shape[1], size=(*rows.shape, scores.shape[1]))
    return _pool(scores[rows[:, :, None], columns], statistic)


def _draw_crossed(scores: Array, columns: Indices, rng: np.random.Generator, statistic: Statistic) -> Array:
    rows = _draw(len(columns), len(scores), rng)
    return _pool(scores[rows[:, :, None], columns[:, None, :]], statistic)


def _estimate(value: float, drawn: Array, confidence: float) -> Estimate:
    low, high = cut_tails(drawn, confidence)
    return Estimate(value, float(low), float(high))
