"""Errors of motion tasks: errors of the joints, or of the tip position and the angles α and β."""

import numpy as np

from prp_gym.robot.arrays import Array, zeros
from prp_gym.tasks.fields import ObservationLayout
from prp_gym.tasks.parts import ErrorFunction

SCORED_ANGLES = 2  # α and β; γ is constant


class JointErrors(ErrorFunction):
    """Tracking errors of the arm's joints, and the effort.

    Args:
        layout: Layout of the observation.
    """

    def __init__(self, layout: ObservationLayout) -> None:
        self._measured = layout.index("joint_position")
        self._desired = layout.index("desired_joint_position")

    def errors(self, ground_truth: Array, torque: Array) -> Array:
        """(..., 2, 3): joint tracking error [rad, m, rad] and torque [N m, N, N m]."""
        errors = zeros((*torque.shape[:-1], 2, 3), torque)
        desired, measured = ground_truth[..., self._desired], ground_truth[..., self._measured]
        np.subtract(desired, measured, out=errors[..., 0, :])
        errors[..., 1, :] = torque
        return errors


class PoseErrors(ErrorFunction):
    """Errors of the tip's position and of two angles, and the effort.

    Args:
        layout: Layout of the observation.
    """

    def __init__(self, layout: ObservationLayout) -> None:
        self._measured = layout.index("end_effector_pose")
        self._desired = layout.index("desired_pose")

    def errors(self, ground_truth: Array, torque: Array) -> Array:
        """(..., 3, 3): tip position error [m], errors of α and β [rad], torque [N m, N, N m]."""
        return stack_errors(ground_truth[..., self._desired] - ground_truth[..., self._measured], torque)


def stack_errors(pose_error: Array, torque: Array) -> Array:
    """Stack the errors of the tip position, of α and β, and the effort in the order of the reward terms.

    Args:
        pose_error: Pose error (..., 6) [m, m, m, rad, rad, rad].
        torque: Commanded torque (..., 3) [N m, N, N m].

    Returns:
        Errors (..., 3, 3), where rows of two components end with a zero.
    """
    errors = zeros((*torque.shape[:-1], 3, 3), torque)
    errors[..., 0, :] = pose_error[..., :3]
    errors[..., 1, :SCORED_ANGLES] = pose_error[..., 3 : 3 + SCORED_ANGLES]
    errors[..., 2, :] = torque
    return errors
