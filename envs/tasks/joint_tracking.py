"""PRP-JointTracking-v0: follow a joint-space trajectory."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from prp_gym.envs.base.arm_task import check_joint_limits
from prp_gym.envs.base.joint_task import JointTask
from prp_gym.envs.base.reference_draws import Draw, StartOptions
from prp_gym.envs.config import describe
from prp_gym.envs.environment import PRPEnv
from prp_gym.envs.vector import PRPVectorEnv
from prp_gym.errors import UnknownNameError
from prp_gym.robot.arrays import Array
from prp_gym.tasks.trajectory import Sine

REFERENCES = ("quintic", "sine", "constant")


@dataclass(frozen=True)
class TrackingOptions(StartOptions):
    """Keywords of the task beside the common ones.

    Raises:
        UnknownNameError: a reference or start that does not exist.
    """

    reference: str = field(
        default="quintic",
        metadata=describe("", "`quintic` (through waypoints, at rest in each), `sine` or `constant`"),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.reference not in REFERENCES:
            raise UnknownNameError("reference", self.reference, REFERENCES)


class JointTracking(JointTask):
    """Follow q_d(t). Source: [R] 6.4, 7.1."""

    environment_id = "PRP-JointTracking-v0"

    def draw_trajectory(self, rng: np.random.Generator, joint_position: Array, goal: Array | None) -> Draw:
        """A reference of the chosen kind; a goal replaces its end, centre or position."""
        draw: dict[str, Callable[[np.random.Generator, Array, Array | None], Draw]] = {
            "quintic": self._draw_quintic,
            "sine": self._draw_sine,
            "constant": self.draw_constant,
        }
        return draw[self.options.reference](rng, joint_position, goal)

    def _draw_quintic(self, rng: np.random.Generator, joint_position: Array, goal: Array | None) -> Draw:
        return self.draw_waypoints(rng, joint_position, goal, self.options.start), joint_position

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


class JointTrackingVectorEnv(PRPVectorEnv):
    """Many of `JointTrackingEnv`, stepped together."""

    environment_class = JointTrackingEnv
