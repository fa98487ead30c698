"""PRP-JointRegulation-v0: bring the joints to a position and hold it."""

from typing import Any

import numpy as np

from prp_gym.envs.config import EnvConfig
from prp_gym.envs.data import load_task_numbers
from prp_gym.envs.environment import PRPEnv, nominal_arm
from prp_gym.envs.joint_task import JointTask, check_joint_limits
from prp_gym.robot.arrays import Array
from prp_gym.tasks.task import Task
from prp_gym.tasks.trajectory import Constant, Trajectory


class JointRegulation(JointTask):
    """Hold q_d. Source: [R] 6.1-6.3, 7.1."""

    environment_id = "PRP-JointRegulation-v0"

    def draw_trajectory(
        self, rng: np.random.Generator, joint_position: Array, goal: Array | None
    ) -> tuple[Trajectory, Array]:
        """A constant reference; see `JointTask.draw_trajectory`."""
        drawn = self.ranges["goal"].draw(rng)
        target = drawn if goal is None else goal
        check_joint_limits(self.arm, "goal", target)
        return Constant(target[None]), joint_position


class JointRegulationEnv(PRPEnv):
    """Bring the joints to a position and hold it.

    Scenario `report` starts at home and asks for (π/2 rad, -0.2 m, π rad); the others draw start and
    goal over nearly the whole joint range.
    """

    task_class = JointRegulation

    @classmethod
    def _make_task(cls, config: EnvConfig, options: Any) -> Task[Any]:
        numbers = load_task_numbers(JointRegulation.environment_id)
        return JointRegulation(numbers, config.load_scenario(), nominal_arm())
