"""What a metric is: a declaration with name, unit and definition, and the function that computes it."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from prp_gym.evaluation.rollout import Rollout
from prp_gym.robot.arrays import Array


@dataclass(frozen=True)
class Metric:
    """A declared metric of an episode.

    Attributes:
        name: in results and tables.
        units: one a component.
        definition: one sentence.
        requires: fields and cost terms of an episode without which it does not exist.
        compute: from a recorded episode, as many numbers as units.
        known_as: its name in ISO 9283 or in control engineering; empty where it has none.
        higher_is_better: the direction.
        survives_divergence: whether it means something for an episode that was cut short.
    """

    name: str
    units: tuple[str, ...]
    definition: str
    requires: tuple[str, ...]
    compute: Callable[[Rollout], Array]
    known_as: str = ""
    higher_is_better: bool = False

    survives_divergence: ClassVar[bool] = False

    def exists(self, rollout: Rollout) -> bool:
        """Whether an episode has all that the metric requires."""
        costs = {name for name in rollout.info if name.startswith("cost_")}
        return costs.union(rollout.fields).issuperset(self.requires)

    def components(self, rollout: Rollout) -> int:
        """How many numbers the metric of an episode has."""
        return len(self.units)

    def values(self, rollout: Rollout) -> Array:
        """The metric of an episode, (components); NaN where a divergence took its meaning."""
        if rollout.diverged and not self.survives_divergence:
            return np.full(self.components(rollout), np.nan)
        return self.compute(rollout)


class JointMetric(Metric):
    """A metric with one number a joint; a robot of fewer joints than units has the first units."""

    def components(self, rollout: Rollout) -> int:
        """The number of joints."""
        return int(rollout.torque.shape[-1])


class OutcomeMetric(Metric):
    """A metric that counts for an episode that was cut short, too."""

    survives_divergence = True
