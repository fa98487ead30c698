"""PRP-JointRegulation-v0: bring the joints to a position and hold it."""

import numpy as np

from prp_gym.envs.base.joint_task import JointTask
from prp_gym.envs.base.reference_draws import Draw
from prp_gym.envs.environment import PRPEnv
from prp_gym.envs.vector import PRPVectorEnv
from prp_gym.robot.arrays import Array


class JointRegulation(JointTask):
    """Hold q_d. Source: [R] 6.1-6.3, 7.1."""

    environment_id = "PRP-JointRegulation-v0"

    def draw_trajectory(self, rng: np.random.Generator, joint_position: Array, goal: Array | None) -> Draw:
        """A constant reference; see `FreeTask.draw_trajectory`."""
        return self.draw_constant(rng, joint_position, goal)


class JointRegulationEnv(PRPEnv):
    """Bring the joints to a position and hold it.

    Scenario `report` starts at home and asks for (π/2 rad, -0.2 m, π rad); the others draw start and
    goal over nearly the whole joint range.
    """

    task_class = JointRegulation


class JointRegulationVectorEnv(PRPVectorEnv):
    """Many of `JointRegulationEnv`, stepped together."""

    environment_class = JointRegulationEnv
