"""Conversion of motions between joint space and operational space."""

import numpy as np
from numpy.typing import ArrayLike

from prp_gym.robot.arrays import Array, apply, as_vectors, broadcast, solve_least_squares, zeros
from prp_gym.robot.components import components, from_components, product
from prp_gym.robot.inverse_kinematics import InverseKinematics


class MotionConversion(InverseKinematics):
    """Converts position, velocity and acceleration between joint space and operational space.

    The pose's angles α and β determine joints 1 and 3, so that a motion of the pose determines the branch.
    """

    def pose_motion(
        self, joint_position: ArrayLike, joint_velocity: ArrayLike, joint_acceleration: ArrayLike
    ) -> tuple[Array, Array, Array]:
        """The pose's motion x = k(q), ẋ = J_A q̇, ẍ = J_A q̈ + J̇_A q̇.

        Args:
            joint_position: (..., 3) [rad, m, rad].
            joint_velocity: (..., 3) [rad/s, m/s, rad/s].
            joint_acceleration: (..., 3) [rad/s², m/s², rad/s²].

        Returns:
            pose (..., 6) [m, m, m, rad, rad, rad], its rate and its second derivative (..., 6).

        Raises:
            ShapeError: an argument does not have three components.

        Source: [S] 3.6, 3.8.
        """
        q, velocity, acceleration = broadcast(
            as_vectors(joint_position, "joint_position"),
            as_vectors(joint_velocity, "joint_velocity"),
            as_vectors(joint_acceleration, "joint_acceleration"),
        )
        trig = self._trigonometry(q)
        J_A, moving = self._jacobian_entries(trig), components(velocity)
        rate, held = product(J_A, 6, moving), product(J_A, 6, components(acceleration))
        drift = product(self._derivative_entries(moving, trig), 6, moving)
        second = {index: a + b for index, (a, b) in enumerate(zip(held, drift, strict=True))}
        return (
            self._pose(q, trig),
            from_components(dict(enumerate(rate)), (6,), q),
            from_components(second, (6,), q),
        )

    def joint_position_of_pose(self, pose: ArrayLike) -> Array:
        """The joint position of a pose, without regard to the joint limits.

        Joints 1 and 3 follow from the angles α and β, including full turns; the slide follows from the tip
        position along the slide's direction. For a pose that the arm cannot attain, the angles are attained
        and the tip is as close to the position as the slide permits.

        Args:
            pose: (..., 6) [m, m, m, rad, rad, rad].

        Returns:
            (..., 3) [rad, m, rad].

        Raises:
            ShapeError: an argument does not have six components.

        Source: [R] 1.3, for the tip frame.
        """
        x = as_vectors(pose, "pose", 6)
        q_1 = x[..., 3]
        joints = zeros((*x.shape[:-1], 3), x)
        joints[..., 0], joints[..., 2] = q_1, np.pi / 2 - x[..., 4]
        along_slide = x[..., 0] * np.sin(q_1) - x[..., 1] * np.cos(q_1)
        joints[..., 1] = along_slide - self.reach(joints)
        return joints

    def joint_motion(
        self, pose: ArrayLike, velocity: ArrayLike, acceleration: ArrayLike
    ) -> tuple[Array, Array, Array]:
        """Motion of the joints: q of `joint_position_of_pose`, q̇ = J_A⁺ẋ, q̈ = J_A⁺(ẍ - J̇_A q̇), with J_A at q.

        Args:
            pose: (..., 6) [m, m, m, rad, rad, rad].
            velocity: (..., 6) per second.
            acceleration: (..., 6) per second squared.

        Returns:
            Joint position, velocity and acceleration (..., 3) [rad, m, rad] and per second.

        Raises:
            ShapeError: an argument does not have six components.

        Source: [S] 3.7.
        """
        pose, velocity, acceleration = broadcast(
            as_vectors(pose, "pose", 6),
            as_vectors(velocity, "velocity", 6),
            as_vectors(acceleration, "acceleration", 6),
        )
        q = self.joint_position_of_pose(pose)
        trig = self._trigonometry(q)
        J_A = self._jacobian(q, trig)
        joint_velocity = solve_least_squares(J_A, velocity)
        drift = apply(self._jacobian_derivative(joint_velocity, trig), joint_velocity)
        return q, joint_velocity, solve_least_squares(J_A, acceleration - drift)
