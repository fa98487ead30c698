"""PRP-JointTracking-v0: follow a joint-space trajectory."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from prp_gym.envs.config import describe
from prp_gym.envs.environment import PRPEnv
from prp_gym.envs.joint_task import Draw, JointTask, check_joint_limits
from prp_gym.errors import UnknownNameError
from prp_gym.robot.arm import PRPArm
from prp_gym.robot.arrays import Array
from prp_gym.tasks.scenario import Scenario
from prp_gym.tasks.task import TaskNumbers
from prp_gym.tasks.trajectory import QuinticWaypoints, Sine

REFERENCES = ("quintic", "sine", "constant")
STARTS = ("scenario", "first_waypoint", "home")


@dataclass(frozen=True)
class TrackingOptions:
    """Keywords of the task beside the common ones.

    Raises:
        UnknownNameError: a reference or start that does not exist.
    """

    reference: str = field(
        default="quintic",
        metadata=describe("", "`quintic` (through waypoints, at rest in each), `sine` or `constant`"),
    )
    start: str = field(
        default="scenario",
        metadata=describe(
            "",
            "where the quintic begins: `first_waypoint` holds the first waypoint until its time (a step at"
            " t = 0, as the report's author ran it), `home` begins at the arm's initial position;"
            " `scenario`: `first_waypoint` in `report`, else `home`",
        ),
    )

    def __post_init__(self) -> None:
        if self.reference not in REFERENCES:
            raise UnknownNameError("reference", self.reference, REFERENCES)
        if self.start not in STARTS:
            raise UnknownNameError("start", self.start, STARTS)


class JointTracking(JointTask):
    """Follow q_d(t). Source: [R] 6.4, 7.1.

    Args:
        numbers: from the task's data file.
        scenario: the conditions of the episodes.
        arm: the nominal arm.
        options: the task's own keywords.
    """

    environment_id = "PRP-JointTracking-v0"

    def __init__(
        self, numbers: TaskNumbers, scenario: Scenario, arm: PRPArm, options: TrackingOptions
    ) -> None:
        super().__init__(numbers, scenario, arm, options)
        self._kind = options.reference
        self._from_home = options.start == "home" or (
            options.start == "scenario" and not scenario.deterministic
        )

    def draw_trajectory(self, rng: np.random.Generator, joint_position: Array, goal: Array | None) -> Draw:
        """A reference of the chosen kind; a goal replaces its end, centre or position."""
        draw: dict[str, Callable[[np.random.Generator, Array, Array | None], Draw]] = {
            "quintic": self._draw_quintic,
            "sine": self._draw_sine,
            "constant": self.draw_constant,
        }
        return draw[self._kind](rng, joint_position, goal)

    def _draw_quintic(self, rng: np.random.Generator, joint_position: Array, goal: Array | None) -> Draw:
        waypoints = self.ranges["waypoints"].draw(rng).reshape(-1, 3)
        times = np.cumsum(self.ranges["interval"].draw(rng))
        if goal is not None:
            waypoints[-1] = goal
        check_joint_limits(self.arm, "goal", waypoints[-1])
        if self._from_home:
            waypoints = np.concatenate([joint_position[None], waypoints])
            times = np.concatenate([[0.0], times])
        return QuinticWaypoints(times[None], waypoints[None]), joint_position

    def _draw_sine(self, rng: np.random.Generator, joint_position: Array, goal: Array | None) -> Draw:
        center = self.ranges["center"].draw(rng)
        amplitude = self.ranges["amplitude"].draw(rng)
        frequency = self.ranges["frequency"].draw(rng)
        phase = self.ranges["phase"].draw(rng)
        if goal is not None:
            center = goal
            check_joint_limits(self.arm, "goal", center)
            if self.scenario.joint_stops:
                check_joint_limits(self.arm, "goal plus amplitude", center + amplitude)
                check_joint_limits(self.arm, "goal minus amplitude", center - amplitude)
        sine = Sine(center[None], amplitude[None], 2 * np.pi * frequency[None], phase[None])
        if self.scenario.deterministic:
            return sine, joint_position
        return sine, sine.sample(np.zeros(1))[0, :3]


class JointTrackingEnv(PRPEnv):
    """Follow a joint-space trajectory.

    Scenario `report` runs the report's waypoints (or its sine) from home; the others draw waypoints
    over nearly the whole joint range and begin at the arm's initial position.
    """

    task_class = JointTracking
    options_class = TrackingOptions
