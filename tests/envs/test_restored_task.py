"""A restored environment goes on with the task of the saved one, whatever that remembers."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from prp_gym.envs import JointRegulation, JointRegulationEnv
from prp_gym.robot.arrays import Array
from prp_gym.tasks.trajectory_task import TrajectoryStart


class RestlessTask(JointRegulation):
    """Its errors depend on what it drew at an episode's start."""

    def begin(self, ids: NDArray[np.intp], starts: Sequence[TrajectoryStart]) -> None:
        super().begin(ids, starts)
        self.weight = 1.0 + abs(float(starts[0].joint_position[0]))

    def errors(self, ground_truth: Array, torque: Array) -> Array:
        return self.weight * super().errors(ground_truth, torque)


class RestlessEnv(JointRegulationEnv):
    task_class = RestlessTask


def test_restored_environment_is_judged_by_the_restored_task() -> None:
    env, other = RestlessEnv(), RestlessEnv()
    env.reset(seed=0)
    other.reset(seed=1)
    other.set_state(env.get_state())
    action = np.zeros(3, dtype=np.float32)
    assert other.step(action)[1] == env.step(action)[1]
