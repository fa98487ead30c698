"""Errors of force tasks: the force error along the surface normal, and the pose error in other directions."""

import numpy as np

from prp_gym.envs.base.motion_errors import SCORED_ANGLES
from prp_gym.robot.arrays import Array, dot, norm
from prp_gym.tasks.fields import ObservationLayout
from prp_gym.tasks.parts import ErrorFunction


class ForceErrors(ErrorFunction):
    """Force error, deviation from the desired pose in the other directions, and the effort.

    Args:
        layout: Layout of the observation.
    """

    def __init__(self, layout: ObservationLayout) -> None:
        self._measured = layout.index("end_effector_pose")
        self._desired = layout.index("desired_pose")
        self._force = layout.index("contact_force")
        self._desired_force = layout.index("desired_force")

    def errors(self, ground_truth: Array, torque: Array) -> Array:
        """(..., 4, 3): force [N], tip position along the surface [m], α and β [rad], torque [N m, N, N m]."""
        desired, force = ground_truth[..., self._desired_force], ground_truth[..., self._force]
        magnitude = norm(desired)
        inward = desired / magnitude[..., None]
        pose_error = ground_truth[..., self._desired] - ground_truth[..., self._measured]
        deviation = pose_error[..., :3]
        errors = np.zeros((*torque.shape[:-1], 4, 3))
        errors[..., 0, 0] = magnitude - dot(force, inward)
        errors[..., 1, :] = deviation - dot(deviation, inward)[..., None] * inward
        errors[..., 2, :SCORED_ANGLES] = pose_error[..., 3 : 3 + SCORED_ANGLES]
        errors[..., 3, :] = torque
        return errors
