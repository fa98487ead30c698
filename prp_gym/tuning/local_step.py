"""A step from the best candidate so far, with a length that adapts to how often steps succeed."""

import math
from collections.abc import Sequence

import numpy as np

from prp_gym.tuning.search_space import Parameter
from prp_gym.tuning.trial import Trial

_FIRST_LENGTH = 0.3  # standard deviation of a factor's logarithm
_LENGTHS = (0.02, 1.0)
_LONGER = 1.5  # after a success; four failures take it back


def is_local(index: int) -> bool:
    """Whether the candidate with this index is a step from the best one before it; the first is not."""
    return index % 6 > 0


def step_length(trials: Sequence[Trial]) -> float:
    """Standard deviation of the next step, in the logarithm of the factors.

    Source: Rechenberg 1973, the 1/5 success rule.
    """
    length, best = _FIRST_LENGTH, -math.inf
    for index, trial in enumerate(trials):
        if is_local(index):
            length *= _LONGER if trial.score > best else _LONGER**-0.25
            length = min(max(length, _LENGTHS[0]), _LENGTHS[1])
        best = max(best, trial.score)
    return length


def local_step(
    parameters: Sequence[Parameter], trials: Sequence[Trial], rng: np.random.Generator
) -> dict[str, float]:
    """The best factors so far, each times a log-normal one, within their ranges.

    Args:
        parameters: parameters with the ranges of their factors.
        trials: finished trials, at least one.
        rng: random generator of the step.
    """
    best = max(trials, key=lambda trial: trial.score)
    shifts = step_length(trials) * rng.standard_normal(len(parameters))
    return {
        item.name: min(max(best.factors[item.name] * math.exp(shift), item.low), item.high)
        for item, shift in zip(parameters, shifts.tolist(), strict=True)
    }
