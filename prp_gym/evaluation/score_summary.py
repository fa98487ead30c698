"""`ScoreSummary`: what the scores of a policy's episodes are, and what a single number of them would hide."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from prp_gym.artifacts import to_array
from prp_gym.evaluation.failure import FAILURES
from prp_gym.evaluation.statistics import (
    Estimate,
    bootstrap_interquartile_mean,
    bootstrap_mean,
    worst_twentieth,
)
from prp_gym.robot.arrays import Array


@dataclass(frozen=True, eq=False)
class ScoreSummary:
    """Scores of the episodes of one policy under one condition.

    Attributes:
        mean: mean over the episodes with a 95 % interval, by which policies are ranked [1].
        interquartile_mean: interquartile mean with a 95 % interval, which leaves failed episodes out [1].
        worst_twentieth: mean of the worst 5 % of the episodes, of one at least [1].
        failure: share of failed episodes by kind, in the order of `FAILURES` [%]; NaN where it is unknown.
    """

    mean: Estimate
    interquartile_mean: Estimate
    worst_twentieth: float
    failure: Array

    @classmethod
    def of(cls, metrics: Mapping[str, Array], seed: int) -> Self:
        """From the metrics of every episode (episodes, components).

        Args:
            metrics: metrics by name, with `score`; without `failure` that is unknown.
            seed: random seed of the bootstrap.
        """
        scores = metrics["score"][:, 0]
        return cls(
            mean=bootstrap_mean(scores, np.random.default_rng(seed)),
            interquartile_mean=bootstrap_interquartile_mean(scores, np.random.default_rng(seed)),
            worst_twentieth=worst_twentieth(scores),
            failure=failure_of(metrics),
        )

    @classmethod
    def of_record(cls, record: Mapping[str, Any]) -> Self:
        """From an evaluation as the results file holds it, also one of version 0.1."""
        episodes = record["episodes"]
        names = [name for name in ("score", "failure") if name in episodes]
        return cls.of({name: to_array(episodes[name]) for name in names}, int(record["seeds"][0]))

    def skill(self, floor: float) -> float:
        """Share of what lies between a floor and a perfect score: (score - floor)/(1 - floor) [1].

        Args:
            floor: score of the best floor [1].
        """
        return (self.mean.value - floor) / (1.0 - floor) if floor < 1.0 else np.nan

    def to_plain(self) -> dict[str, Any]:
        """As the results file holds it."""
        return {
            "score": self.mean._asdict(),
            "interquartile_mean": self.interquartile_mean._asdict(),
            "worst_twentieth": self.worst_twentieth,
            "failure": dict(zip(FAILURES, self.failure.tolist(), strict=True)),
        }


def failure_of(metrics: Mapping[str, Array]) -> Array:
    """Share of failed episodes by kind (kinds) [%], of metrics (..., components); NaN if unknown."""
    if "failure" not in metrics:
        return np.full(len(FAILURES), np.nan)
    share: Array = metrics["failure"].reshape(-1, len(FAILURES)).mean(axis=0)
    return share
