"""Starts of tasks in free space: the arm's initial state and the reference of the episode."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from prp_gym.checks import choice
from prp_gym.envs.base.arm_world import ARM_OPTIONS, ArmWorld, check_joint_limits, checked_start
from prp_gym.envs.config import describe
from prp_gym.robot.arm import PRPArm
from prp_gym.robot.arrays import Array
from prp_gym.tasks.parts import EpisodeStart, StartSampler
from prp_gym.tasks.ranges import Draws
from prp_gym.tasks.setup import TaskSetup
from prp_gym.tasks.trajectory import Constant, QuinticWaypoints, Sine, Trajectory

STARTS = ("scenario", "first_waypoint", "home")
START_KEYWORD = describe(
    "",
    "where the quintic trajectory starts: `first_waypoint` holds the first waypoint until its time (a step at"
    " t = 0, as the report's author ran it), `home` starts at the arm's initial position;"
    " `scenario`: `first_waypoint` in `report`, else `home`",
)

Made = tuple[Trajectory, Array]
"""References, n rows, and the initial joint positions (n, 3) [rad, m, rad] of their episodes."""


@dataclass(frozen=True)
class StartOptions:
    """The keyword for where a reference through waypoints starts.

    Raises:
        UnknownNameError: a start that does not exist.
    """

    start: str = field(default="scenario", metadata=START_KEYWORD)

    def __post_init__(self) -> None:
        choice("start", self.start, STARTS)


def path_from(start: Array, waypoints: Array, intervals: Array) -> tuple[Array, Array]:
    """Times (..., K + 1) [s] and positions (..., K + 1, d) of paths that leave a start (..., d) at t = 0.

    Args:
        start: Initial positions (..., d).
        waypoints: Positions after the initial one (..., K, d).
        intervals: Times between successive positions (..., K) [s].
    """
    times = np.zeros((*intervals.shape[:-1], intervals.shape[-1] + 1))
    np.cumsum(intervals, axis=-1, out=times[..., 1:])
    return times, np.concatenate([start[..., None, :], waypoints], axis=-2)


class ReferenceSampler(ABC):
    """Makes the references of episodes in free space from numbers that are drawn for them.

    Args:
        setup: Numbers, scenario, keywords and period of the task.
        arm: Nominal arm.

    Attributes:
        names: Ranges of the task from which the reference is drawn, in this order.
    """

    names: ClassVar[tuple[str, ...]]

    def __init__(self, setup: TaskSetup, arm: PRPArm) -> None:
        self.setup = setup
        self.arm = arm

    @abstractmethod
    def make(self, drawn: Mapping[str, Array], joint_position: Array, goal: Array | None) -> Made:
        """Make the references of n episodes.

        Args:
            drawn: Numbers (n, size) by `names`.
            joint_position: Joint positions drawn for the starts (n, 3) [rad, m, rad].
            goal: Joint positions (n, 3) that replace the drawn goals [rad, m, rad]; None keeps them.

        Raises:
            JointLimitError: a reference would leave the joint limits.
        """


class ConstantSampler(ReferenceSampler):
    """Draws a constant joint position."""

    names = ("goal",)

    def make(self, drawn: Mapping[str, Array], joint_position: Array, goal: Array | None) -> Made:
        """See `ReferenceSampler.make`."""
        target = drawn["goal"] if goal is None else goal
        check_joint_limits(self.arm, "goal", target)
        return Constant(target), joint_position


class WaypointSampler(ReferenceSampler):
    """Draws quintic segments through joint waypoints; the keyword `start` says where they start."""

    names = ("waypoints", "interval")

    def make(self, drawn: Mapping[str, Array], joint_position: Array, goal: Array | None) -> Made:
        """See `ReferenceSampler.make`; a goal replaces the last waypoint."""
        return QuinticWaypoints(*self.path(drawn, joint_position, goal)), joint_position

    def path(
        self, drawn: Mapping[str, Array], joint_position: Array, goal: Array | None
    ) -> tuple[Array, Array]:
        """Times (n, K) [s] and joint positions (n, K, 3) [rad, m, rad] of the waypoints; see `make`."""
        intervals, start = drawn["interval"], self.setup.options.start
        waypoints = drawn["waypoints"].reshape(len(intervals), -1, 3)
        if goal is not None:
            waypoints[:, -1] = goal
        check_joint_limits(self.arm, "goal", waypoints[:, -1])
        if start == "home" or (start == "scenario" and not self.setup.scenario.deterministic):
            return path_from(joint_position, waypoints, intervals)
        return np.cumsum(intervals, axis=-1), waypoints


class SineSampler(ReferenceSampler):
    """Draws sinusoidal motions of the joints about a centre."""

    names = ("center", "amplitude", "frequency", "phase")

    def make(self, drawn: Mapping[str, Array], joint_position: Array, goal: Array | None) -> Made:
        """See `ReferenceSampler.make`; a goal replaces the centre."""
        scenario, amplitude = self.setup.scenario, drawn["amplitude"]
        center = drawn["center"] if goal is None else goal
        if goal is not None:
            check_joint_limits(self.arm, "goal", center)
            if scenario.joint_stops:
                check_joint_limits(self.arm, "goal plus amplitude", center + amplitude)
                check_joint_limits(self.arm, "goal minus amplitude", center - amplitude)
        sine = Sine(center, amplitude, 2 * np.pi * drawn["frequency"], drawn["phase"])
        if scenario.deterministic:
            return sine, joint_position
        return sine, sine.sample(np.zeros(len(center)))[:, :3]


class TrackingStarts(StartSampler[EpisodeStart]):
    """Samples starts in free space.

    Args:
        world: The arm in free space.
        reference: Sampler of the references.
    """

    reset_options = ARM_OPTIONS

    def __init__(self, world: ArmWorld[EpisodeStart], reference: ReferenceSampler) -> None:
        self._arm = world.arm
        self._reference = reference
        ranges = reference.setup.ranges
        self._draws = Draws({name: ranges[name] for name in ("joint_position", *reference.names)})

    def draw(self, rngs: Sequence[np.random.Generator], options: Mapping[str, Array]) -> EpisodeStart:
        """See `StartSampler.draw`."""
        drawn = self._draws.draw(rngs)
        start = options.get("joint_position", drawn["joint_position"])
        trajectory, position = self._reference.make(drawn, start, options.get("goal"))
        return EpisodeStart(*checked_start(self._arm, position, options), trajectory)
