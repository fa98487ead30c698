"""`Outcome`: all that a comparison finds, and how it is written."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Self

from prp_gym.comparison.audit import Audit, audit_rewards
from prp_gym.comparison.effort import Effort, learning_efforts
from prp_gym.comparison.statistics import (
    Aggregate,
    Duel,
    aggregate_tasks,
    compare_best,
    estimate_score,
    training_spread,
)
from prp_gym.comparison.values import AGENT, Place, Record, group_places
from prp_gym.evaluation.results import to_plain


@dataclass(frozen=True, eq=False)
class Outcome:
    """What a comparison finds.

    Attributes:
        places: environments and scenarios with their policies.
        duels: the best law against the best agent, where there are both.
        aggregates: families of policies over their tasks.
        efforts: what learning cost.
        audits: reward against physical error.
        seed: of every bootstrap.
    """

    places: tuple[Place, ...]
    duels: tuple[Duel, ...]
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
        places = group_places(records)
        return cls(
            places=tuple(places),
            duels=tuple(compare_best(places, seed)),
            aggregates=tuple(aggregate_tasks(places, seed)),
            efforts=tuple(learning_efforts(places)),
            audits=tuple(audit_rewards(places, seed)),
            seed=seed,
        )

    @property
    def spread(self) -> bool:
        """Whether there are agents, which differ by training seed."""
        return any(place.of_kind(AGENT) for place in self.places)

    @property
    def learned(self) -> bool:
        """Whether there is a policy whose training or tuning is known."""
        return any(entry.histories for place in self.places for entry in place.entries)

    def to_plain(self) -> dict[str, Any]:
        """All of it but the records themselves, as strict JSON knows it."""
        plain: dict[str, Any] = to_plain(
            {
                "scores": [row for place in self.places for row in self._scores(place)],
                "duels": [_duel(duel) for duel in self.duels],
                "aggregates": [_aggregate(item) for item in self.aggregates],
                "efforts": self.efforts,
                "audits": [_audit(audit) for audit in self.audits],
            }
        )
        return plain

    def _scores(self, place: Place) -> list[dict[str, Any]]:
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


def _duel(duel: Duel) -> dict[str, Any]:
    intervals = ("law_score", "agent_score", "difference")
    return {
        **vars(duel),
        **{name: getattr(duel, name)._asdict() for name in intervals},
        "apart": duel.apart,
        "verdict": duel.verdict,
    }


def _audit(audit: Audit) -> dict[str, Any]:
    changed = {"policies": dict(audit.policies), "correlation": audit.correlation._asdict()}
    return {**vars(audit), **changed, "flagged": audit.flagged}


def _aggregate(item: Aggregate) -> dict[str, Any]:
    parts = ("score", "reference", "profile")
    return {**vars(item), **{name: getattr(item, name)._asdict() for name in parts}}
