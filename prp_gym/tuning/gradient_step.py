"""Steps along the derivatives of the score: a quasi-Newton search in the logarithms of the factors."""

import math
from collections.abc import Sequence

import numpy as np

from prp_gym.robot.arrays import Array
from prp_gym.tuning.local_step import is_local, local_step
from prp_gym.tuning.search_space import Parameter
from prp_gym.tuning.trial import Trial

_FIRST = 0.1  # longest change of a factor's logarithm in a step along the derivatives themselves
_LONGEST = 0.5  # the same in a quasi-Newton step
_SHORTEST = 1.0 / 8.0  # share of a step that is tried last
_MEMORY = 8  # steps from which the curvature is estimated
_LEAST_CURVATURE = 1e-12


class _Search:
    """A quasi-Newton search for a maximum, with backtracking.

    Args:
        parameters: parameters with the ranges of their factors.

    Attributes:
        score: score of the point of departure.
    """

    def __init__(self, parameters: Sequence[Parameter]) -> None:
        ranges = [(math.log(item.low), math.log(item.high)) for item in parameters]
        self._low, self._high = np.array(ranges).T
        self._steps: list[tuple[Array, Array]] = []
        self.score, self._share = -math.inf, 1.0
        self._here = self._slopes = self._move = np.zeros_like(self._low)

    def learn(self, here: Array, score: float, slopes: Array | None) -> bool:
        """Take a candidate as the new point of departure if it is better, else the half of the step.

        Args:
            here: logarithms of its factors (parameters).
            score: its score.
            slopes: derivatives of the score by these (parameters); None for a candidate that was refused.

        Returns:
            whether it is better.
        """
        if slopes is None or score <= self.score:
            self._share *= 0.5
            if self._share < _SHORTEST and self._steps:  # the curvature may mislead
                self._steps.clear()
                self._turn()
            return False
        if math.isfinite(self.score):
            self._steps.append((here - self._here, self._slopes - slopes))
            del self._steps[:-_MEMORY]
        self._here, self.score, self._slopes = here, score, slopes
        self._turn()
        return True

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

    A quasi-Newton step (L-BFGS) leads from the best candidate; while it is not better, half of the step is
    tried. Where no step helps, as where the score jumps or is chaotic, candidates at random distances from
    the best one are tried until one is better, see `local_step`; derivatives lead on from there. All of this
    follows from the trials.

    Args:
        parameters: parameters with the ranges of their factors.
        trials: finished trials, at least one, each but refused ones with derivatives.
        seed: random seed of the random steps.

    Source: Nocedal and Wright 2006, algorithm 7.4.
    """
    search = _Search(parameters)
    random: list[Trial] = []  # the best candidate, and the random steps from it since
    for index, trial in enumerate(trials):
        here = np.array([math.log(trial.factors[item.name]) for item in parameters])
        slopes = np.array([trial.slopes[item.name] for item in parameters]) if trial.slopes else None
        if index and not is_local(index) and trial.score <= search.score:
            continue  # a candidate of a sampler, which tells nothing of the step
        if search.learn(here, trial.score, slopes):
            random = [trial]
        elif search.is_stuck:
            random.append(trial)
    if search.is_stuck:
        rng = np.random.default_rng(np.random.SeedSequence((seed, len(trials))))
        return local_step(parameters, random, rng)
    return {
        item.name: min(max(math.exp(value), item.low), item.high)
        for item, value in zip(parameters, search.next.tolist(), strict=True)
    }
