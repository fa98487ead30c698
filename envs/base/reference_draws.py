"""How the free-space tasks draw their references, in joint space or as a task sees them."""

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from prp_gym.envs.base.arm_task import ArmTask, check_joint_limits, path_from
from prp_gym.envs.config import describe
from prp_gym.errors import UnknownNameError
from prp_gym.robot.arrays import Array
from prp_gym.tasks.trajectory import Constant, QuinticWaypoints, Trajectory
from prp_gym.tasks.trajectory_task import TrajectoryStart

STARTS = ("scenario", "first_waypoint", "home")
START_KEYWORD = describe(
    "",
    "where the quintic begins: `first_waypoint` holds the first waypoint until its time (a step at"
    " t = 0, as the report's author ran it), `home` begins at the arm's initial position;"
    " `scenario`: `first_waypoint` in `report`, else `home`",
)

Draw = tuple[Trajectory, Array]


@dataclass(frozen=True)
class StartOptions:
    """Where a reference through waypoints begins.

    Raises:
        UnknownNameError: a start that does not exist.
    """

    start: str = field(default="scenario", metadata=START_KEYWORD)

    def __post_init__(self) -> None:
        if self.start not in STARTS:
            raise UnknownNameError("start", self.start, STARTS)


class FreeTask(ArmTask[TrajectoryStart]):
    """A task in free space."""

    @abstractmethod
    def draw_trajectory(self, rng: np.random.Generator, joint_position: Array, goal: Array | None) -> Draw:
        """Draw one reference.

        Args:
            rng: the environment's own generator.
            joint_position: (3) drawn for the start [rad, m, rad].
            goal: (3) that replaces the drawn one, or None [rad, m, rad].

        Returns:
            the reference, one row, and the start (3) that goes with it [rad, m, rad].

        Raises:
            JointLimitError: the reference would leave the joint limits.
        """

    def draw(self, rng: np.random.Generator, options: Mapping[str, Array]) -> TrajectoryStart:
        """See `Task.draw`."""
        drawn = self.ranges["joint_position"].draw(rng)
        start = options.get("joint_position", drawn)
        trajectory, position = self.draw_trajectory(rng, start, options.get("goal"))
        return TrajectoryStart(*self.checked_start(position, options), trajectory)

    def draw_constant(self, rng: np.random.Generator, joint_position: Array, goal: Array | None) -> Draw:
        """A constant reference, drawn or given; see `draw_trajectory`."""
        drawn = self.ranges["goal"].draw(rng)
        target = drawn if goal is None else goal
        check_joint_limits(self.arm, "goal", target)
        return Constant(target[None]), joint_position

    def draw_waypoints(
        self, rng: np.random.Generator, joint_position: Array, goal: Array | None, start: str
    ) -> QuinticWaypoints:
        """Quintic segments through drawn waypoints of the joints; `start` is one of `STARTS`."""
        waypoints = self.ranges["waypoints"].draw(rng).reshape(-1, 3)
        intervals = self.ranges["interval"].draw(rng)
        if goal is not None:
            waypoints[-1] = goal
        check_joint_limits(self.arm, "goal", waypoints[-1])
        if start == "home" or (start == "scenario" and not self.scenario.deterministic):
            times, waypoints = path_from(joint_position, waypoints, intervals)
        else:
            times = np.cumsum(intervals)
        return QuinticWaypoints(times[None], waypoints[None])
