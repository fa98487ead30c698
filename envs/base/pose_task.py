"""What the operational-space tasks share: a reference trajectory of the pose."""

from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from prp_gym.envs.base.arm_task import ArmTask
from prp_gym.envs.base.reference_draws import FreeTask
from prp_gym.robot.arm import PRPArm
from prp_gym.robot.arrays import Array
from prp_gym.tasks.fields import POSE_REFERENCE_FIELDS, Field
from prp_gym.tasks.scenario import Scenario
from prp_gym.tasks.task import TaskNumbers
from prp_gym.tasks.trajectory import Trajectory
from prp_gym.tasks.trajectory_task import StartT, TrajectoryStart

SCORED_ANGLES = 2  # α and β; γ never moves


def sample_pose(arm: PRPArm, trajectory: Trajectory, time: Array) -> Array:
    """A reference as a motion of the pose.

    Args:
        arm: whose kinematics turn joint motions into motions of the pose.
        trajectory: of the joints or of the pose, N rows.
        time: (..., N) [s].

    Returns:
        (..., N, 18): pose, its rate, its second derivative.
    """
    samples = trajectory.sample(time)
    if samples.shape[-1] == 18:
        return samples
    return np.concatenate(arm.pose_motion(samples[..., :3], samples[..., 3:6], samples[..., 6:]), axis=-1)


class PoseReferenceTask(ArmTask[StartT]):
    """A task whose reference is a motion of the pose."""

    reference_fields: ClassVar[tuple[Field, ...]] = POSE_REFERENCE_FIELDS

    def __init__(self, numbers: TaskNumbers, scenario: Scenario, options: Any, period: float) -> None:
        super().__init__(numbers, scenario, options, period)
        self._measured = self.layout.index("end_effector_pose")
        self._desired = self.layout.index("desired_pose")

    def reference(self, time: Array, ids: NDArray[np.intp] | None = None) -> Array:
        """See `Task.reference`."""
        return sample_pose(self.arm, self.rows(ids), time)

    def tip_path(self, trajectory: Trajectory, time: Array) -> Array:
        """See `ArmTask.tip_path`."""
        return sample_pose(self.arm, trajectory, time)[..., :3]

    def pose_error(self, ground_truth: Array) -> Array:
        """x_d - x (..., 6) [m, m, m, rad, rad, rad]."""
        error: Array = ground_truth[..., self._desired] - ground_truth[..., self._measured]
        return error


class PoseTask(PoseReferenceTask[TrajectoryStart], FreeTask):
    """Follow a trajectory of the pose in free space."""

    def errors(self, ground_truth: Array, torque: Array) -> Array:
        """(..., 3, 3): tip position error [m], errors of α and β [rad], torque [N m, N, N m]."""
        return stack_errors(self.pose_error(ground_truth), torque)


def stack_errors(pose_error: Array, torque: Array) -> Array:
    """Errors of the tip, of α and β, and the effort, as the reward takes them.

    Args:
        pose_error: (..., 6) [m, m, m, rad, rad, rad].
        torque: (..., 3) [N m, N, N m].

    Returns:
        (..., 3, 3).
    """
    errors = np.zeros((*torque.shape[:-1], 3, 3))
    errors[..., 0, :] = pose_error[..., :3]
    errors[..., 1, :SCORED_ANGLES] = pose_error[..., 3 : 3 + SCORED_ANGLES]
    errors[..., 2, :] = torque
    return errors
