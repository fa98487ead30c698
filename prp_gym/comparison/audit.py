"""Whether the reward ranks policies as the physical error of the task does."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from prp_gym.comparison.rank import rank_correlation, resampled_correlations
from prp_gym.comparison.task_error import physical_errors
from prp_gym.comparison.values import Condition
from prp_gym.evaluation.resampling import cut_tails
from prp_gym.evaluation.scoring import scoring_of
from prp_gym.evaluation.statistics import Estimate, interquartile_mean
from prp_gym.robot.arrays import Array
from prp_gym.tasks.spec import TaskError

LEAST_CORRELATION = 0.8
"""Rank correlation below which a reward is flagged."""

_CONFIDENCE = 0.95
_RESAMPLES = 500  # about a dozen of them lie beyond each end of the interval

_Indices = NDArray[np.int64]


@dataclass(frozen=True)
class Audit:
    """Reward against physical error under one condition.

    Attributes:
        environment_id: id of the environment.
        scenario: name of the scenario.
        physical_error: name of the task's physical error.
        reason: why this error measures success in the task.
        policies: score and physical error by the name of the policy.
        correlation: Spearman's rank correlation between the score and the smallness of the error; 1 if both
            rank the policies alike. Its 95 % interval is over the episodes, for these policies.
    """

    environment_id: str
    scenario: str
    physical_error: str
    reason: str
    policies: Mapping[str, tuple[float, float]]
    correlation: Estimate

    @property
    def flagged(self) -> bool:
        """Whether the correlation is too low or undefined."""
        return not self.correlation.value >= LEAST_CORRELATION


def audit_rewards(conditions: Iterable[Condition], seed: int) -> list[Audit]:
    """An audit of every condition over all its policies, including those with low scores.

    Conditions of a task that declares no physical error are left out.

    Args:
        conditions: environments and scenarios with their policies.
        seed: random seed of the bootstrap.
    """
    audits = []
    for condition in conditions:
        error = scoring_of(condition.environment_id).error
        if error is not None:
            audits.append(_audit(condition, error, seed))
    return audits


def _audit(condition: Condition, task_error: TaskError, seed: int) -> Audit:
    episodes = len(condition.seeds)
    every = np.arange(episodes, dtype=np.int64)[None]
    drawn = np.random.default_rng(seed).integers(episodes, size=(_RESAMPLES, episodes))
    scores, errors = _aggregate(condition, task_error, every)
    value = rank_correlation(scores[0], -errors[0])
    drawn_scores, drawn_errors = _aggregate(condition, task_error, drawn)
    found = resampled_correlations(drawn_scores, -drawn_errors)
    low, high = cut_tails(found, _CONFIDENCE) if len(found) else (np.nan, np.nan)
    both = zip(scores[0].tolist(), errors[0].tolist(), strict=True)
    return Audit(
        environment_id=condition.environment_id,
        scenario=condition.scenario,
        physical_error=task_error.name,
        reason=task_error.reason,
        policies=dict(zip([entry.policy for entry in condition.entries], both, strict=True)),
        correlation=Estimate(value, float(low), float(high)),
    )


def _aggregate(condition: Condition, task_error: TaskError, drawn: _Indices) -> tuple[Array, Array]:
    """Score and error of every policy over drawn episodes (resamples, n), each (resamples, policies)."""
    scores = [_mean(entry.scores, drawn) for entry in condition.entries]
    errors = [_mean(physical_errors(entry, task_error), drawn) for entry in condition.entries]
    return np.stack(scores, axis=-1), np.stack(errors, axis=-1)


def _mean(values: Array, drawn: _Indices) -> Array:
    """Interquartile mean over all rows of the drawn columns: (rows, m), (resamples, n) -> (resamples)."""
    return interquartile_mean(np.concatenate(values[:, drawn], axis=-1))
