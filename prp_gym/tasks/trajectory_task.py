"""A task whose reference is a trajectory, drawn anew for every episode."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from prp_gym.errors import EpisodeError
from prp_gym.tasks.scenario import Scenario
from prp_gym.tasks.task import EpisodeStart, Task, TaskNumbers
from prp_gym.tasks.trajectory import Trajectory


@dataclass(frozen=True, eq=False)
class TrajectoryStart(EpisodeStart):
    """A start with its reference.

    Attributes:
        trajectory: one row.
    """

    trajectory: Trajectory


StartT = TypeVar("StartT", bound=TrajectoryStart)


class TrajectoryTask(Task[StartT]):
    """A task that keeps a reference trajectory for each of N environments."""

    def __init__(self, numbers: TaskNumbers, scenario: Scenario, options: Any, period: float) -> None:
        super().__init__(numbers, scenario, options, period)
        self._trajectory: Trajectory | None = None

    @property
    def trajectory(self) -> Trajectory:
        """The reference of every environment, N rows."""
        if self._trajectory is None:
            raise EpisodeError("no episode has begun yet: call reset() first.")
        return self._trajectory

    def rows(self, ids: NDArray[np.intp] | None) -> Trajectory:
        """The references of some environments, or of all."""
        return self.trajectory if ids is None else self.trajectory.rows(ids)

    def begin(self, ids: NDArray[np.intp], starts: Sequence[StartT]) -> None:
        """See `Task.begin`."""
        rows = [start.trajectory for start in starts]
        stacked = type(rows[0]).concatenate(rows)
        if self._trajectory is None:
            self._trajectory = stacked
        else:
            self._trajectory.assign(ids, stacked)
