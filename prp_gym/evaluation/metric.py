"""`Metric`: a declaration with name, unit and definition, and the function that computes the metric."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from prp_gym.errors import InvalidValueError, ShapeError
from prp_gym.evaluation.column import Column
from prp_gym.evaluation.rollout import Rollout
from prp_gym.registry import NOT_IN_THE_REPORT
from prp_gym.robot.arrays import Array


@dataclass(frozen=True)
class MetricGroup:
    """Metrics of one quantity, which stand together in lists.

    Attributes:
        heading: heading of the group in the documentation.
        chapter: first chapter of the report in which the quantity is controlled, for the order of lists.
    """

    heading: str
    chapter: float = NOT_IN_THE_REPORT


OTHER = MetricGroup("Other")
"""Group of the metrics that name none."""


@dataclass(frozen=True)
class Presentation:
    """How a metric is listed, shown and read.

    Attributes:
        group: group of metrics with which the metric is listed.
        column: column of the metric's median in tables; None if it is never shown there.
        known_as: name of the metric in ISO 9283 or in control engineering; empty where it has none.
        higher_is_better: whether larger values are better.
    """

    group: MetricGroup = OTHER
    column: Column | None = None
    known_as: str = ""
    higher_is_better: bool = False


@dataclass(frozen=True)
class Metric:
    """A declared metric of an episode.

    Attributes:
        name: name of the metric in results and tables.
        units: units of the components, one for each.
        definition: definition in one sentence.
        requires: fields and cost terms that an episode must have for the metric to exist.
        compute: function of a recorded episode that returns as many numbers as there are units; a metric with
            one unit may return a single number.
        presentation: how the metric is listed, shown and read.
        revision: revision of the definition; every change of the metric's values raises it.
    """

    name: str
    units: tuple[str, ...]
    definition: str
    requires: tuple[str, ...]
    compute: Callable[[Rollout], Array | float]
    presentation: Presentation = Presentation()
    revision: int = 1

    survives_divergence: ClassVar[bool] = False

    def __post_init__(self) -> None:
        column = self.column
        if column is not None and len(column.units) != len(self.units):
            what, allowed = f"units of the column of metric {self.name!r}", f"{len(self.units)} of them"
            raise InvalidValueError(what, column.units, allowed)

    @property
    def chapter(self) -> float:
        """Chapter of the metric's group, for the order of lists."""
        return self.presentation.group.chapter

    @property
    def group(self) -> str:
        """Heading under which the metric is listed."""
        return self.presentation.group.heading

    @property
    def column(self) -> Column | None:
        """Column of the metric's median in tables; None if it is never shown there."""
        return self.presentation.column

    @property
    def known_as(self) -> str:
        """Name of the metric in ISO 9283 or in control engineering; empty where it has none."""
        return self.presentation.known_as

    @property
    def higher_is_better(self) -> bool:
        """Whether larger values are the better ones."""
        return self.presentation.higher_is_better

    def exists(self, rollout: Rollout) -> bool:
        """Whether an episode has all that the metric requires."""
        fields, info = rollout.fields, rollout.info
        return all(name in fields or (name in info and name.startswith("cost_")) for name in self.requires)

    def components(self, rollout: Rollout) -> int:
        """How many numbers the metric of an episode has."""
        return len(self.units)

    def values(self, rollout: Rollout) -> Array:
        """The metric of an episode.

        Args:
            rollout: an episode for which the metric exists.

        Returns:
            (components); NaN where a divergence left it without meaning.

        Raises:
            ShapeError: the metric's function returned another number of components.
        """
        count = self.components(rollout)
        if rollout.diverged and not self.survives_divergence:
            return np.full(count, np.nan)
        values = np.atleast_1d(np.asarray(self.compute(rollout), dtype=np.float64))
        if values.shape != (count,):
            raise ShapeError(
                f"metric {self.name!r}", values.shape, f"({count},), one number for each component"
            )
        return values


class JointMetric(Metric):
    """A metric with one number for each joint; a robot of fewer joints than units has the first units."""

    def components(self, rollout: Rollout) -> int:
        """The number of joints."""
        return int(rollout.torque.shape[-1])


class OutcomeMetric(Metric):
    """A metric that also has a meaning for an episode that a divergence has cut short."""

    survives_divergence = True
