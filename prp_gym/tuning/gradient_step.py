"""Steps along the derivatives of the score: resilient propagation in the logarithms of the factors."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from prp_gym.robot.arrays import Array
from prp_gym.tuning.search_space import Parameter
from prp_gym.tuning.trial import Trial

_FIRST_LENGTH = 0.1  # of a step in the logarithm of a factor
_LONGEST, _SHORTEST = 0.5, 1e-3
_LONGER, _SHORTER = 1.2, 0.5
_RESTART = 0.3  # standard deviation of the distance of a new start from the best candidate


@dataclass(frozen=True, eq=False)
class _Step:
    """What a step depends on, besides the derivatives where it begins.

    Attributes:
        lengths: lengths of the next steps (parameters).
        slopes: derivatives before (parameters), 0 where there were none or the last step was taken back.
        moves: last step (parameters).
    """

    lengths: Array
    slopes: Array
    moves: Array

    @classmethod
    def first(cls, count: int) -> "_Step":
        """What the first step of several parameters depends on."""
        return cls(np.full(count, _FIRST_LENGTH), np.zeros(count), np.zeros(count))

    def next(self, slopes: Array, worse: bool) -> "_Step":
        """The next step.

        Args:
            slopes: derivatives by the logarithms of the factors (parameters).
            worse: whether the last step has lowered the score.
        """
        same = slopes * self.slopes
        lengths = np.where(same > 0.0, np.minimum(self.lengths * _LONGER, _LONGEST), self.lengths)
        lengths = np.where(same < 0.0, lengths * _SHORTER, lengths)
        kept = np.where(same < 0.0, 0.0, slopes)
        moves = np.sign(kept) * lengths
        if worse:
            moves = np.where(same < 0.0, -self.moves, moves)
        return _Step(lengths, kept, moves)

    def halved(self) -> "_Step":
        """Half of the way back, after a candidate without derivatives."""
        return _Step(self.lengths * _SHORTER, np.zeros_like(self.slopes), -self.moves * _SHORTER)


def gradient_step(parameters: Sequence[Parameter], trials: Sequence[Trial], seed: int) -> dict[str, float]:
    """The factors of the next candidate of a search along derivatives.

    Each factor has a step length of its own in its logarithm, which grows as long as the derivative keeps its
    sign and is halved where it changes; a step after which the sign has changed and the score is lower is
    taken back. So steps depend on no scale of the score. Once all steps are short, the search starts again
    at a random distance from the best candidate so far. All of this follows from the trials.

    Args:
        parameters: parameters with the ranges of their factors.
        trials: finished trials, at least one, each but refused ones with derivatives.
        seed: random seed of new starts.

    Source: Igel and Hüsken 2003, iRprop+.
    """
    step, target = _Step.first(len(parameters)), np.zeros(len(parameters))
    before = -math.inf
    for index, trial in enumerate(trials):
        here = np.array([math.log(trial.factors[item.name]) for item in parameters])
        slopes = np.array([trial.slopes.get(item.name, 0.0) for item in parameters])
        step = step.next(slopes, trial.score < before) if trial.slopes else step.halved()
        before, target = trial.score, here + step.moves
        if (step.lengths < _SHORTEST).all() or not step.moves.any():
            step, before = _Step.first(len(parameters)), -math.inf
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
    start: Array = here + _RESTART * noise
    return start
