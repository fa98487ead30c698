"""`Outcome`: all that a comparison finds, and how it is written."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Self

from prp_gym.comparison.audit import Audit, audit_rewards
from prp_gym.comparison.effort import Effort, learning_efforts
from prp_gym.comparison.statistics import (
    Aggregate,
    PairwiseComparison,
    aggregate_tasks,
    compare_best,
    estimate_score,
    training_spread,
)
from prp_gym.comparison.values import AGENT, Condition, Record, group_conditions
from prp_gym.evaluation.results import to_plain


@dataclass(frozen=True, eq=False)
class Outcome:
    """What a comparison finds.

    Attributes:
        conditions: environments and scenarios with their policies.
        pairwise_comparisons: the best law against the best agent, where there are both.
        aggregates: families of policies over their tasks.
        efforts: what learning cost.
        audits: reward against physical error.
        seed: of every bootstrap.
    """

    conditions: tuple[Condition, ...]
    pairwise_comparisons: tuple[PairwiseComparison, ...]
    aggregates: tuple[Aggregate, ...]
    efforts: tuple[Effort, ...]
    audits: tuple[Audit, ...]
    seed: int

    @classmethod
    def of(cls, records: Iterable[Record], seed: int) -> Self:
        """From the records of a comparison, as its results hold them.

        Args:
            records: one a policy, place and training seed.
            seed: of every bootstrap.

        Raises:
            InvalidValueError: policies that did not meet the same episodes.
        """
        conditions = group_conditions(records)
        return cls(
            conditions=tuple(conditions),
            pairwise_comparisons=tuple(compare_best(conditions, seed)),
            aggregates=tuple(aggregate_tasks(conditions, seed)),
            efforts=tuple(learning_efforts(conditions)),
            audits=tuple(audit_rewards(conditions, seed)),
            seed=seed,
        )

    @property
    def spread(self) -> bool:
        """Whether there are agents, which differ by training seed."""
        return any(place.of_kind(AGENT) for place in self.conditions)

    @property
    def learned(self) -> bool:
        """Whether there is a policy whose training or tuning is known."""
        return any(entry.histories for place in self.conditions for entry in place.entries)

    def to_plain(self) -> dict[str, Any]:
        """All of it but the records themselves, as strict JSON knows it."""
        plain: dict[str, Any] = to_plain(
            {
                "scores": [row for place in self.conditions for row in self._scores(place)],
                "pairwise_comparisons": [_pairwise(pairwise) for pairwise in self.pairwise_comparisons],
                "aggregates": [_aggregate(item) for item in self.aggregates],
                "efforts": self.efforts,
                "audits": [_audit(audit) for audit in self.audits],
            }
        )
        return plain

    def _scores(self, place: Condition) -> list[dict[str, Any]]:
        return [
            {
                "environment": place.environment_id,
                "scenario": place.scenario,
                "policy": entry.policy,
                "kind": entry.kind,
                "score": estimate_score(entry, self.seed)._asdict(),
                "training_seeds": entry.training_seeds,
                "training_spread": training_spread(entry),
                "compute_time_per_step": entry.compute_time,
            }
            for entry in place.entries
        ]


def _pairwise(pairwise: PairwiseComparison) -> dict[str, Any]:
    intervals = ("controller_score", "agent_score", "difference")
    return {
        **vars(pairwise),
        **{name: getattr(pairwise, name)._asdict() for name in intervals},
        "apart": pairwise.apart,
        "verdict": pairwise.verdict,
    }


def _audit(audit: Audit) -> dict[str, Any]:
    changed = {"policies": dict(audit.policies), "correlation": audit.correlation._asdict()}
    return {**vars(audit), **changed, "flagged": audit.flagged}


def _aggregate(item: Aggregate) -> dict[str, Any]:
    parts = ("score", "reference", "profile")
    return {**vars(item), **{name: getattr(item, name)._asdict() for name in parts}}
