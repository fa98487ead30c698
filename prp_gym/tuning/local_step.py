"""A step from the best candidate so far, with a length that adapts to how often steps succeed."""

import math
from collections.abc import Sequence

import numpy as np

from prp_gym.tuning.search_space import Parameter
from prp_gym.tuning.trial import Trial

_FIRST_LENGTH = 0.3  # standard deviation of a factor's logarithm
_LENGTHS = (0.02, 1.0)
_LONGER = 1.5  # after a success; four failures take it back
_FAR = 1.0  # the same of a step of few factors, which does not adapt
_FEW = 3  # a step of few factors changes one in three


def is_local(index: int) -> bool:
    """Whether the candidate with this index is a step from the best one before it; the first is not."""
    return index % 6 > 0


def is_of_few(index: int) -> bool:
    """Whether the step of the candidate with this index changes few of the factors, but by much."""
    return index % 3 == 2


def step_length(trials: Sequence[Trial]) -> float:
    """Standard deviation of the next step, in the logarithm of the factors.

    Source: Rechenberg 1973, the 1/5 success rule.
    """
    length, best = _FIRST_LENGTH, -math.inf
    for index, trial in enumerate(trials):
        if is_local(index) and not is_of_few(index):
            length *= _LONGER if trial.score > best else _LONGER**-0.25
            length = min(max(length, _LENGTHS[0]), _LENGTHS[1])
        best = max(best, trial.score)
    return length


def local_step(
    parameters: Sequence[Parameter], trials: Sequence[Trial], rng: np.random.Generator, few: bool = False
) -> dict[str, float]:
    """The best factors so far, each times a log-normal one, within their ranges.

    Args:
        parameters: parameters with the ranges of their factors.
        trials: finished trials, at least one.
        rng: random generator of the step.
        few: whether to change one in three of the factors, by steps that do not adapt to the trials: where
            some factors have to stay as they are, as those of a target that must be rendered exactly, a step
            of all shows nothing about the others.
    """
    best = max(trials, key=lambda trial: trial.score)
    shifts = (_FAR if few else step_length(trials)) * rng.standard_normal(len(parameters))
    if few:
        shifts[rng.permutation(len(shifts))[math.ceil(len(shifts) / _FEW) :]] = 0.0
    return {
        item.name: min(max(best.factors[item.name] * math.exp(shift), item.low), item.high)
        for item, shift in zip(parameters, shifts.tolist(), strict=True)
    }
