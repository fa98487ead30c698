"""What the joint-space tasks share: a reference trajectory of the joints, judged joint by joint."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from prp_gym.envs.base.reference_draws import FreeTask
from prp_gym.robot.arrays import Array
from prp_gym.tasks.fields import JOINT_REFERENCE_FIELDS
from prp_gym.tasks.scenario import Scenario
from prp_gym.tasks.task import TaskNumbers
from prp_gym.tasks.trajectory import Trajectory


class JointTask(FreeTask):
    """Follow a joint-space trajectory; the errors are those of the joints, and the effort."""

    reference_fields = JOINT_REFERENCE_FIELDS

    def __init__(self, numbers: TaskNumbers, scenario: Scenario, options: Any, period: float) -> None:
        super().__init__(numbers, scenario, options, period)
        self._measured = self.layout.index("joint_position")
        self._desired = self.layout.index("desired_joint_position")

    def reference(self, time: Array, ids: NDArray[np.intp] | None = None) -> Array:
        """See `Task.reference`."""
        return self.rows(ids).sample(time)

    def tip_path(self, trajectory: Trajectory, time: Array) -> Array:
        """See `ArmTask.tip_path`."""
        return self.arm.forward_kinematics(trajectory.sample(time)[..., :3])[..., :3]

    def errors(self, ground_truth: Array, torque: Array) -> Array:
        """(..., 2, 3): joint tracking error [rad, m, rad] and torque [N m, N, N m]."""
        errors = np.empty((*torque.shape[:-1], 2, 3))
        desired, measured = ground_truth[..., self._desired], ground_truth[..., self._measured]
        np.subtract(desired, measured, out=errors[..., 0, :])
        errors[..., 1, :] = torque
        return errors
