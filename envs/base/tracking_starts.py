"""Starts of tasks in free space: the arm's initial state and the reference of the episode."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from prp_gym.checks import choice
from prp_gym.envs.base.arm_world import ARM_OPTIONS, ArmWorld, check_joint_limits, checked_start
from prp_gym.envs.config import describe
from prp_gym.robot.arm import PRPArm
from prp_gym.robot.arrays import Array
from prp_gym.tasks.parts import EpisodeStart, StartSampler
from prp_gym.tasks.setup import TaskSetup
from prp_gym.tasks.trajectory import Constant, QuinticWaypoints, Sine, Trajectory

STARTS = ("scenario", "first_waypoint", "home")
START_KEYWORD = describe(
    "",
    "where the quintic trajectory starts: `first_waypoint` holds the first waypoint until its time (a step at"
    " t = 0, as the report's author ran it), `home` starts at the arm's initial position;"
    " `scenario`: `first_waypoint` in `report`, else `home`",
)

Draw = tuple[Trajectory, Array]
"""A reference, one row, and the initial joint position (3) [rad, m, rad] of its episode."""


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
    """Times (K + 1) [s] and positions (K + 1, d) of a path that leaves a start (d) at t = 0.

    Args:
        start: Initial position (d).
        waypoints: Positions after the initial one (K, d).
        intervals: Times between successive positions (K) [s].
    """
    return np.concatenate([[0.0], np.cumsum(intervals)]), np.concatenate([start[None], waypoints])


class ReferenceSampler(ABC):
    """Draws the reference of an episode in free space.

    Args:
        setup: Numbers, scenario, keywords and period of the task.
        arm: Nominal arm.
    """

    def __init__(self, setup: TaskSetup, arm: PRPArm) -> None:
        self.setup = setup
        self.arm = arm

    @abstractmethod
    def draw(self, rng: np.random.Generator, joint_position: Array, goal: Array | None) -> Draw:
        """Draw one reference.

        Args:
            rng: Generator of the environment.
            joint_position: Joint position drawn for the start (3) [rad, m, rad].
            goal: Joint position (3) that replaces the drawn goal [rad, m, rad]; None keeps it.

        Raises:
            JointLimitError: the reference would leave the joint limits.
        """


class ConstantSampler(ReferenceSampler):
    """Draws a constant joint position."""

    def draw(self, rng: np.random.Generator, joint_position: Array, goal: Array | None) -> Draw:
        """See `ReferenceSampler.draw`."""
        drawn = self.setup.ranges["goal"].draw(rng)
        target = drawn if goal is None else goal
        check_joint_limits(self.arm, "goal", target)
        return Constant(target[None]), joint_position


class WaypointSampler(ReferenceSampler):
    """Draws quintic segments through joint waypoints; the keyword `start` says where they start."""

    def draw(self, rng: np.random.Generator, joint_position: Array, goal: Array | None) -> Draw:
        """See `ReferenceSampler.draw`; a goal replaces the last waypoint."""
        return self.draw_waypoints(rng, joint_position, goal), joint_position

    def draw_waypoints(
        self, rng: np.random.Generator, joint_position: Array, goal: Array | None
    ) -> QuinticWaypoints:
        """Draw the quintic segments, one row."""
        ranges, start = self.setup.ranges, self.setup.options.start
        waypoints = ranges["waypoints"].draw(rng).reshape(-1, 3)
        intervals = ranges["interval"].draw(rng)
        if goal is not None:
            waypoints[-1] = goal
        check_joint_limits(self.arm, "goal", waypoints[-1])
        if start == "home" or (start == "scenario" and not self.setup.scenario.deterministic):
            times, waypoints = path_from(joint_position, waypoints, intervals)
        else:
            times = np.cumsum(intervals)
        return QuinticWaypoints(times[None], waypoints[None])


class SineSampler(ReferenceSampler):
    """Draws sinusoidal motions of the joints about a centre."""

    def draw(self, rng: np.random.Generator, joint_position: Array, goal: Array | None) -> Draw:
        """See `ReferenceSampler.draw`; a goal replaces the centre."""
        ranges, scenario = self.setup.ranges, self.setup.scenario
        center = ranges["center"].draw(rng)
        amplitude = ranges["amplitude"].draw(rng)
        frequency = ranges["frequency"].draw(rng)
        phase = ranges["phase"].draw(rng)
        if goal is not None:
            center = goal
            check_joint_limits(self.arm, "goal", center)
            if scenario.joint_stops:
                check_joint_limits(self.arm, "goal plus amplitude", center + amplitude)
                check_joint_limits(self.arm, "goal minus amplitude", center - amplitude)
        sine = Sine(center[None], amplitude[None], 2 * np.pi * frequency[None], phase[None])
        if scenario.deterministic:
            return sine, joint_position
        return sine, sine.sample(np.zeros(1))[0, :3]


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

    def draw(self, rng: np.random.Generator, options: Mapping[str, Array]) -> EpisodeStart:
        """See `StartSampler.draw`."""
        drawn = self._reference.setup.ranges["joint_position"].draw(rng)
        start = options.get("joint_position", drawn)
        trajectory, position = self._reference.draw(rng, start, options.get("goal"))
        return EpisodeStart(*checked_start(self._arm, position, options), trajectory)
