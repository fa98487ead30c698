"""PRP-PoseRegulation-v0: bring the end effector to a pose and hold it."""

import numpy as np

from prp_gym.envs.base.pose_task import PoseTask
from prp_gym.envs.base.reference_draws import Draw
from prp_gym.envs.environment import PRPEnv
from prp_gym.envs.vector import PRPVectorEnv
from prp_gym.robot.arrays import Array


class PoseRegulation(PoseTask):
    """Hold x_d, the pose of a joint position. Source: [R] 9.1."""

    environment_id = "PRP-PoseRegulation-v0"

    def draw_trajectory(self, rng: np.random.Generator, joint_position: Array, goal: Array | None) -> Draw:
        """A constant reference; see `FreeTask.draw_trajectory`."""
        return self.draw_constant(rng, joint_position, goal)


class PoseRegulationEnv(PRPEnv):
    """Bring the end effector to a pose and hold it.

    Scenario `report` starts at home and asks for the pose of (-π/3 rad, -0.1 m, π/2 rad); the others draw
    start and goal over nearly the whole joint range.
    """

    task_class = PoseRegulation


class PoseRegulationVectorEnv(PRPVectorEnv):
    """Many of `PoseRegulationEnv`, stepped together."""

    environment_class = PoseRegulationEnv
