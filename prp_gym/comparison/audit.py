"""Whether the reward orders policies as the physical errors do that it stands for."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from prp_gym.comparison.rank import rank_correlation, resampled_correlations
from prp_gym.comparison.task_error import TASK_ERRORS, TaskError, physical_errors
from prp_gym.comparison.values import Condition
from prp_gym.evaluation.resampling import cut_tails
from prp_gym.evaluation.statistics import Estimate, interquartile_mean
from prp_gym.robot.arrays import Array

LEAST_CORRELATION = 0.8
"""Rank correlation below which a reward is flagged."""

_CONFIDENCE = 0.95
_RESAMPLES = 500  # a dozen of them beyond either end of the interval


_Indices = NDArray[np.int64]


@dataclass(frozen=True)
class Audit:
    """Reward against physical error at a place.

    Attributes:
        environment_id: of the place.
        scenario: of the place.
        measure: name of the physical error.
        policies: score and error by name.
        correlation: Spearman's, between score and smallness of the error; 1 if both order alike. Its 95 %
            interval is over the episodes, with the policies as they are.
    """

    environment_id: str
    scenario: str
    measure: str
    policies: Mapping[str, tuple[float, float]]
    correlation: Estimate

    @property
    def flagged(self) -> bool:
        """Whether the correlation is too low, or is none."""
        return not self.correlation.value >= LEAST_CORRELATION


def audit_rewards(conditions: Iterable[Condition], seed: int) -> list[Audit]:
    """An audit of every place over all its policies, the bad ones included.

    Args:
        conditions: with their policies.
        seed: of the bootstrap.
    """
    return [_audit(place, TASK_ERRORS[place.environment_id], seed) for place in conditions]


def _audit(place: Condition, task_error: TaskError, seed: int) -> Audit:
    episodes = len(place.seeds)
    every = np.arange(episodes, dtype=np.int64)[None]
    drawn = np.random.default_rng(seed).integers(episodes, size=(_RESAMPLES, episodes))
    scores, errors = _aggregate(place, task_error, every)
    value = rank_correlation(scores[0], -errors[0])
    drawn_scores, drawn_errors = _aggregate(place, task_error, drawn)
    found = resampled_correlations(drawn_scores, -drawn_errors)
    low, high = cut_tails(found, _CONFIDENCE) if len(found) else (np.nan, np.nan)
    pairs = zip(scores[0].tolist(), errors[0].tolist(), strict=True)
    policies = dict(zip([entry.policy for entry in place.entries], pairs, strict=True))
    correlation = Estimate(value, float(low), float(high))
    return Audit(place.environment_id, place.scenario, task_error.name, policies, correlation)


def _aggregate(place: Condition, task_error: TaskError, drawn: _Indices) -> tuple[Array, Array]:
    """Score and error of every policy on episodes (resamples, n), the same for all: (resamples, policies)."""
    scores = [_mean(entry.scores, drawn) for entry in place.entries]
    errors = [_mean(physical_errors(entry, task_error), drawn) for entry in place.entries]
    return np.stack(scores, axis=-1), np.stack(errors, axis=-1)


def _mean(values: Array, drawn: _Indices) -> Array:
    """Interquartile mean over all rows of the drawn columns: (rows, m), (resamples, n) -> (resamples)."""
    return interquartile_mean(np.concatenate(values[:, drawn], axis=-1))
