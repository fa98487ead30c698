"""Whether the reward ranks policies as control engineers would, by criteria that are not its own."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from prp_gym.comparison.rank import (
    concordance,
    distinguished,
    rank_correlation,
    resampled_concordances,
)
from prp_gym.comparison.values import Condition, Entry
from prp_gym.evaluation.resampling import cut_tails
from prp_gym.evaluation.scoring import scoring_of
from prp_gym.evaluation.statistics import Estimate
from prp_gym.robot.arrays import Array
from prp_gym.tasks.setup import MUJOCO
from prp_gym.tasks.spec import Criterion

LEAST_CORRELATION = 0.8
"""Rank correlation below which the reward contradicts a criterion."""

LEAST_POLICIES = 40
"""Number of policies from which an audit says something."""

REPORTED = tuple(Criterion(name, np.inf, required=False) for name in ("excess_energy", "energy"))
"""Criteria that are shown for information in every audit: a task may be worth its energy."""

STANDARD_ERRORS = 2.0
"""Standard errors of a mean difference over the episodes that set two policies apart by a criterion."""

_CONFIDENCE = 0.95
_RESAMPLES = 500  # about a dozen of them lie beyond each end of the interval
_BEST = 0.1  # share of the policies that must not be bad by any criterion

_Indices = NDArray[np.int64]


@dataclass(frozen=True)
class Finding:
    """Score against one criterion over many policies.

    Attributes:
        metric: metric of the criterion.
        correlation: Goodman and Kruskal's γ between the score and the smallness of the metric: 1 if both rank
            every two policies alike that the criterion distinguishes by more than `STANDARD_ERRORS`. Its
            95 % interval is over the episodes, for these policies.
        counted: share of all cases of two policies that the criterion distinguishes [1].
        unfiltered: γ over all cases of two, also where chance alone may have made the difference.
        spearman: Spearman's rank correlation, which stays below 1 where many policies are equally bad.
        values: mean of the metric for each policy, over episodes.
        offenders: policies in the best tenth by score that are in the worse half by the criterion.
        required: whether the correlation must be high; else it is shown for information.
    """

    metric: str
    correlation: Estimate
    counted: float
    unfiltered: float
    spearman: float
    values: tuple[float, ...]
    offenders: tuple[str, ...]
    required: bool

    @property
    def holds(self) -> bool:
        """Whether the score agrees with the criterion."""
        return not self.required or (self.correlation.value > LEAST_CORRELATION and not self.offenders)


@dataclass(frozen=True)
class Audit:
    """Score against the criteria of a task, under one condition.

    Attributes:
        environment_id: id of the environment.
        scenario: name of the scenario.
        policies: names of the policies.
        scores: mean score of each policy.
        findings: one for each criterion of the task, and for the metrics shown for information.
        engine: name of the engine that simulated the episodes.
    """

    environment_id: str
    scenario: str
    policies: tuple[str, ...]
    scores: tuple[float, ...]
    findings: tuple[Finding, ...]
    engine: str = MUJOCO

    @property
    def holds(self) -> bool:
        """Whether the score agrees with every criterion, over sufficiently many policies."""
        return len(self.policies) >= LEAST_POLICIES and all(item.holds for item in self.findings)

    def to_plain(self) -> dict[str, Any]:
        """The audit as plain values."""
        findings = [
            {**vars(item), "correlation": item.correlation._asdict(), "holds": item.holds}
            for item in self.findings
        ]
        return {**vars(self), "findings": findings, "holds": self.holds}


def audit_rewards(conditions: Iterable[Condition], seed: int) -> list[Audit]:
    """An audit of every condition over all its policies, good and bad.

    Conditions of a task that declares no criteria are left out, and so are criteria that are undefined there.

    Args:
        conditions: environments and scenarios with their policies.
        seed: random seed of the bootstrap.
    """
    return [
        _audit(condition, seed) for condition in conditions if scoring_of(condition.environment_id).criteria
    ]


def criterion_values(entry: Entry, criterion: Criterion) -> Array:
    """What counts of a criterion in every episode of a policy.

    Args:
        entry: a policy under a condition.
        criterion: criterion that the task of the environment declares.

    Returns:
        (rows, evaluation seeds), in the unit of the metric; NaN where the metric is undefined.
    """
    found = entry.metrics[criterion.metric][..., 0]
    failed = (entry.metrics["unsettled"][..., 0] > 0.0) & ~np.isnan(found) & np.isfinite(criterion.worst)
    values: Array = np.where(failed, criterion.worst, np.minimum(found, criterion.worst))
    return values


def _audit(condition: Condition, seed: int) -> Audit:
    episodes = len(condition.seeds)
    drawn = np.random.default_rng(seed).integers(episodes, size=(_RESAMPLES, episodes))
    scores = np.stack([entry.scores.mean(axis=0) for entry in condition.entries])
    names = tuple(entry.policy for entry in condition.entries)
    findings = []
    for criterion in (*scoring_of(condition.environment_id).criteria, *REPORTED):
        values = _values(condition, criterion)
        if values is not None:
            findings.append(_finding(criterion, scores, values, drawn, names))
    means = tuple(scores.mean(axis=1).tolist())
    of_condition = (condition.environment_id, condition.scenario)
    return Audit(*of_condition, names, means, tuple(findings), condition.engine)


def _values(condition: Condition, criterion: Criterion) -> Array | None:
    """What counts of a criterion, (policies, evaluation seeds); None where it is undefined."""
    if not all(criterion.metric in entry.metrics for entry in condition.entries):
        return None
    rows = [criterion_values(entry, criterion).mean(axis=0) for entry in condition.entries]
    values = np.stack(rows)
    return None if np.isnan(values).all() else values


def _finding(
    criterion: Criterion, scores: Array, values: Array, drawn: _Indices, names: tuple[str, ...]
) -> Finding:
    """Scores against values, each (policies, evaluation seeds)."""
    with np.errstate(invalid="ignore"):
        means = np.nanmean(values, axis=1)
        resampled = np.nanmean(values[:, drawn], axis=2).T
    every = scores.mean(axis=1)
    counted = distinguished(values, STANDARD_ERRORS)
    found = resampled_concordances(scores[:, drawn].mean(axis=2).T, -resampled, counted)
    low, high = cut_tails(found, _CONFIDENCE) if len(found) else (np.nan, np.nan)
    best = np.argsort(-every, kind="stable")[: max(1, round(_BEST * len(every)))]
    offenders = tuple(names[index] for index in best if means[index] > np.median(means))
    return Finding(
        criterion.metric,
        Estimate(concordance(every, -means, counted), float(low), float(high)),
        float(counted[np.triu_indices(len(every), 1)].mean()),
        concordance(every, -means),
        rank_correlation(every, -means),
        tuple(means.tolist()),
        offenders if criterion.required else (),
        criterion.required,
    )
