"""`Outcome`: the findings of a comparison, and how they are written."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Self

from prp_gym.artifacts import to_plain
from prp_gym.comparison.effort import Effort, learning_efforts
from prp_gym.comparison.statistics import (
    Aggregate,
    PairwiseComparison,
    aggregate_tasks,
    compare_best,
    score_of,
    summarise,
    training_spread,
)
from prp_gym.comparison.values import AGENT, FLOOR, Condition, Record, group_conditions


@dataclass(frozen=True, eq=False)
class Outcome:
    """The findings of a comparison.

    Attributes:
        conditions: environments and scenarios with their policies.
        pairwise_comparisons: best controller against best agent, under conditions that have both.
        aggregates: families of policies over their tasks.
        efforts: learning effort of the trained and tuned policies.
        seed: random seed of every bootstrap.
    """

    conditions: tuple[Condition, ...]
    pairwise_comparisons: tuple[PairwiseComparison, ...]
    aggregates: tuple[Aggregate, ...]
    efforts: tuple[Effort, ...]
    seed: int

    @classmethod
    def of(cls, records: Iterable[Record], seed: int) -> Self:
        """From the records of a comparison, as its results hold them.

        Args:
            records: one for each policy, condition and training seed.
            seed: random seed of every bootstrap.

        Raises:
            InvalidValueError: policies that were evaluated on different episodes.
        """
        conditions = group_conditions(records)
        return cls(
            conditions=tuple(conditions),
            pairwise_comparisons=tuple(compare_best(conditions, seed)),
            aggregates=tuple(aggregate_tasks(conditions, seed)),
            efforts=tuple(learning_efforts(conditions)),
            seed=seed,
        )

    @property
    def spread(self) -> bool:
        """Whether there are agents, whose scores are spread over training seeds."""
        return any(condition.of_kind(AGENT) for condition in self.conditions)

    @property
    def learned(self) -> bool:
        """Whether the training or tuning of any policy is known."""
        return any(entry.histories for condition in self.conditions for entry in condition.entries)

    def to_plain(self) -> dict[str, Any]:
        """The findings as strict JSON, without the records from which they follow."""
        plain: dict[str, Any] = to_plain(
            {
                "scores": [row for condition in self.conditions for row in self._scores(condition)],
                "pairwise_comparisons": [_pairwise(pairwise) for pairwise in self.pairwise_comparisons],
                "aggregates": [_aggregate(item) for item in self.aggregates],
                "efforts": self.efforts,
            }
        )
        return plain

    def _scores(self, condition: Condition) -> list[dict[str, Any]]:
        floor = max((score_of(entry) for entry in condition.of_kind(FLOOR)), default=math.nan)
        summaries = {entry.policy: summarise(entry, self.seed) for entry in condition.entries}
        return [
            {
                "environment": condition.environment_id,
                "scenario": condition.scenario,
                "engine": condition.engine,
                "policy": entry.policy,
                "kind": entry.kind,
                **summaries[entry.policy].to_plain(),
                "skill": summaries[entry.policy].skill(floor),
                "training_seeds": entry.training_seeds,
                "training_spread": training_spread(entry),
                "compute_time_per_step": entry.compute_time,
            }
            for entry in condition.entries
        ]


def _pairwise(pairwise: PairwiseComparison) -> dict[str, Any]:
    intervals = ("controller_score", "agent_score", "difference")
    return {
        **vars(pairwise),
        **{name: getattr(pairwise, name)._asdict() for name in intervals},
        "apart": pairwise.apart,
        "verdict": pairwise.verdict,
    }


def _aggregate(item: Aggregate) -> dict[str, Any]:
    parts = ("score", "reference", "profile")
    return {**vars(item), **{name: getattr(item, name)._asdict() for name in parts}}
