"""Steps along the derivatives of the score: a quasi-Newton search in the logarithms of the factors."""

import math
from collections.abc import Sequence

import numpy as np

from prp_gym.robot.arrays import Array
from prp_gym.tuning.search_space import Parameter
from prp_gym.tuning.trial import Trial

_FIRST = 0.1  # longest change of a factor's logarithm in a step along the derivatives themselves
_LONGEST = 0.5  # the same in a quasi-Newton step
_SHORTEST = 1.0 / 32.0  # share of a step that is tried last
_DISTANCE = 0.3  # standard deviation of the distance of a new start from the best candidate
_MEMORY = 8  # steps from which the curvature is estimated
_LEAST_CURVATURE = 1e-12


class _Search:
    """A quasi-Newton search for a maximum, with backtracking.

    Args:
        parameters: parameters with the ranges of their factors.
    """

    def __init__(self, parameters: Sequence[Parameter]) -> None:
        ranges = [(math.log(item.low), math.log(item.high)) for item in parameters]
        self._low, self._high = np.array(ranges).T
        self._steps: list[tuple[Array, Array]] = []
        self.restart()

    def restart(self) -> None:
        """Begin at the next candidate, whatever its score."""
        self._steps.clear()
        self._score, self._share = -math.inf, 1.0
        self._here = self._slopes = self._move = np.zeros_like(self._low)

    def learn(self, here: Array, score: float, slopes: Array | None) -> None:
        """Take a candidate as the new point of departure if it is better, else the half of the step.

        Args:
            here: logarithms of its factors (parameters).
            score: its score.
            slopes: derivatives of the score by these (parameters); None for a candidate that was refused.
        """
        if slopes is None or score <= self._score:
            self._share *= 0.5
            if self._share < _SHORTEST and self._steps:  # the curvature may mislead
                self._steps.clear()
                self._turn()
            return
        if math.isfinite(self._score):
            self._steps.append((here - self._here, self._slopes - slopes))
            del self._steps[:-_MEMORY]
        self._here, self._score, self._slopes = here, score, slopes
        self._turn()

    @property
    def is_stuck(self) -> bool:
        """Whether no step from here helps."""
        return self._share < _SHORTEST or not self._move.any()

    @property
    def next(self) -> Array:
        """Logarithms of the factors of the next candidate (parameters)."""
        target: Array = np.clip(self._here + self._share * self._move, self._low, self._high)
        return target

    def _turn(self) -> None:
        """Find the next step: along the derivatives, or with the curvature of the steps before."""
        outward = ((self._here <= self._low) & (self._slopes < 0.0)) | (
            (self._here >= self._high) & (self._slopes > 0.0)
        )
        slopes = np.where(outward, 0.0, self._slopes)
        move, longest = self._newton(slopes), _LONGEST
        if not self._steps or not move @ slopes > 0.0:
            move, longest = slopes, _FIRST
        move = np.where(outward, 0.0, move)
        size = np.abs(move).max(initial=0.0)
        if not math.isfinite(size):
            move, size = np.zeros_like(move), 0.0
        exceeds = size > longest or not self._steps
        self._move = move * (longest / size) if size > 0.0 and exceeds else move
        self._share = 1.0

    def _newton(self, slopes: Array) -> Array:
        """The step to the maximum of a parabola with these derivatives (parameters)."""
        known = [(s, y, float(s @ y)) for s, y in self._steps if s @ y > _LEAST_CURVATURE]
        move, weights = slopes.copy(), []
        for s, y, product in reversed(known):
            weights.append(float(s @ move) / product)
            move = move - weights[-1] * y
        if known:
            _, y, product = known[-1]
            move = move * (product / float(y @ y))
        for (s, y, product), weight in zip(known, reversed(weights), strict=True):
            move = move + (weight - float(y @ move) / product) * s
        return move


def gradient_step(parameters: Sequence[Parameter], trials: Sequence[Trial], seed: int) -> dict[str, float]:
    """The factors of the next candidate of a search along derivatives.

    A quasi-Newton step (L-BFGS) leads from the best candidate since the last start; while it is not better,
    half of the step is tried. Where the score is chaotic, in limit cycles and repeated impacts, derivatives
    are huge and tell nothing: only what is better is taken, and no step is longer than a factor of 1.65. Once
    no step helps, the search starts again at a random distance from the best candidate of all. All of this
    follows from the trials.

    Args:
        parameters: parameters with the ranges of their factors.
        trials: finished trials, at least one, each but refused ones with derivatives.
        seed: random seed of new starts.

    Source: Nocedal and Wright 2006, algorithm 7.4.
    """
    search, target = _Search(parameters), np.zeros(len(parameters))
    for index, trial in enumerate(trials):
        here = np.array([math.log(trial.factors[item.name]) for item in parameters])
        slopes = np.array([trial.slopes[item.name] for item in parameters]) if trial.slopes else None
        search.learn(here, trial.score, slopes)
        target = search.next
        if search.is_stuck:
            search.restart()
            target = _new_start(parameters, trials[: index + 1], (seed, index))
    return {
        item.name: min(max(math.exp(value), item.low), item.high)
        for item, value in zip(parameters, target.tolist(), strict=True)
    }


def _new_start(parameters: Sequence[Parameter], trials: Sequence[Trial], seed: tuple[int, int]) -> Array:
    """Logarithms of factors at a random distance from those of the best candidate."""
    best = max(trials, key=lambda trial: trial.score)
    here = np.array([math.log(best.factors[item.name]) for item in parameters])
    noise = np.random.default_rng(np.random.SeedSequence(seed)).standard_normal(len(parameters))
    start: Array = here + _DISTANCE * noise
    return start
