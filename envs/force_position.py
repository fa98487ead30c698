"""PRP-ForcePosition-v0: press on a surface while moving along it."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from prp_gym.envs.config import describe
from prp_gym.envs.contact_task import ContactStart
from prp_gym.envs.environment import PRPEnv
from prp_gym.envs.force_task import ForceOptions, ForceTask
from prp_gym.errors import UnknownNameError
from prp_gym.robot.arrays import Array
from prp_gym.tasks.trajectory import QuinticWaypoints, Trajectory

STARTS = ("goal", "home")


@dataclass(frozen=True)
class ForcePositionOptions(ForceOptions):
    """Keywords of the task beside the common ones.

    Raises:
        UnknownNameError: a start that does not exist.
    """

    start: str = field(
        default="goal",
        metadata=describe(
            "", "`goal` begins on the reference, `home` at q = 0 as the report's author ran it"
        ),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.start not in STARTS:
            raise UnknownNameError("start", self.start, STARTS)


class ForcePosition(ForceTask):
    """Press with f_d and follow x_d in the rest. Source: [R] 15; [S] 9.4.3."""

    environment_id = "PRP-ForcePosition-v0"

    def draw(self, rng: np.random.Generator, options: Mapping[str, Array]) -> ContactStart:
        """See `Task.draw`."""
        if self.options.start == "home" and "joint_position" not in options:
            drawn = super().draw(rng, options)
            return ContactStart(
                np.zeros(3), drawn.joint_velocity, drawn.trajectory, drawn.surface, drawn.desired_force
            )
        return super().draw(rng, options)

    def draw_reference(self, start: Array, waypoints: Array, intervals: Array) -> Trajectory:
        """Along the surface, from the start through the waypoints."""
        times = np.concatenate([[0.0], np.cumsum(intervals)])
        return QuinticWaypoints(times[None], np.concatenate([start[None], waypoints])[None])


class ForcePositionEnv(PRPEnv):
    """Press on a surface with a given force and follow a pose in the other directions.

    Scored are the force along the surface's normal, and the deviation from the desired pose in the other
    directions. Scenario `report` holds the pose of (-π/2 rad, -0.1 m, -π/6 rad), 0.1 m off a surface at
    x = -0.3078 m, and asks for 0.5 N along +x; its own run, with 1 N/m and from home, needs q_2 = -0.7 m,
    far beyond the slide's limit, so that 50 N/m is the default. The others move the tip along the surface.
    """

    task_class = ForcePosition
    options_class = ForcePositionOptions
