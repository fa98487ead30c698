"""PRP-PoseTracking-v0: follow a trajectory of the end effector's pose."""

from dataclasses import dataclass, field

import numpy as np

from prp_gym.envs.base.pose_task import PoseTask
from prp_gym.envs.base.reference_draws import Draw, StartOptions
from prp_gym.envs.config import describe
from prp_gym.envs.environment import PRPEnv
from prp_gym.envs.vector import PRPVectorEnv
from prp_gym.errors import UnknownNameError
from prp_gym.robot.arrays import Array
from prp_gym.tasks.trajectory import QuinticWaypoints

REFERENCES = ("joint", "pose")


@dataclass(frozen=True)
class PoseTrackingOptions(StartOptions):
    """Keywords of the task beside the common ones.

    Raises:
        UnknownNameError: a reference or start that does not exist.
    """

    reference: str = field(
        default="joint",
        metadata=describe(
            "",
            "space in which the quintic joins the waypoints: `joint` (the arm can follow), or `pose` as in"
            " the report (between the waypoints three joints cannot attain it)",
        ),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.reference not in REFERENCES:
            raise UnknownNameError("reference", self.reference, REFERENCES)


class PoseTracking(PoseTask):
    """Follow x_d(t) through the poses of joint waypoints. Source: [R] 10.1."""

    environment_id = "PRP-PoseTracking-v0"

    def draw_trajectory(self, rng: np.random.Generator, joint_position: Array, goal: Array | None) -> Draw:
        """Quintic segments in the chosen space; a goal replaces their end."""
        joints = self.draw_waypoints(rng, joint_position, goal, self.options.start)
        if self.options.reference == "joint":
            return joints, joint_position
        return QuinticWaypoints(joints.times, self.arm.forward_kinematics(joints.positions)), joint_position


class PoseTrackingEnv(PRPEnv):
    """Follow a trajectory of the end effector's pose.

    Scenario `report` runs through the poses of the report's waypoints from home; the others draw waypoints
    over nearly the whole joint range and begin at the arm's initial pose.
    """

    task_class = PoseTracking
    options_class = PoseTrackingOptions


class PoseTrackingVectorEnv(PRPVectorEnv):
    """Many of `PoseTrackingEnv`, stepped together."""

    environment_class = PoseTrackingEnv
