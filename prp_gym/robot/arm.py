"""`PRPArm`: kinematics and dynamics of the arm in one class."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from prp_gym.robot.arrays import (
    Array,
    apply,
    as_vectors,
    broadcast,
    matrix_like,
    multiply,
    pseudoinverse_transposed,
)
from prp_gym.robot.dynamics import Dynamics
from prp_gym.robot.newton_euler import recursive_newton_euler


class OperationalSpaceDynamics(NamedTuple):
    """B_A(x) ẍ + C_A ẋ + g_A(x) = u - u_e, in the coordinates of the pose.

    Attributes:
        inertia: Inertia matrix B_A = J_A^{+T} B J_A^+, (..., 6, 6), of rank 3.
        coriolis_force: Coriolis and centrifugal force C_A ẋ = (J_A^{+T} C - B_A J̇_A) q̇,
            (..., 6) [N, N, N, N m, N m, N m].
        gravity_force: Gravity force g_A = J_A^{+T} g, (..., 6) [N, N, N, N m, N m, N m].
    """

    inertia: Array
    coriolis_force: Array
    gravity_force: Array


class PRPArm(Dynamics):
    """The three-joint arm: joints 1 and 3 are revolute, joint 2 is prismatic (the name PRP is historical).

    Every method broadcasts over the leading dimensions of its arguments and never modifies them.

    Args:
        parameters: Parameters of the arm; the nominal ones by default.
    """

    def inverse_dynamics(
        self,
        joint_position: ArrayLike,
        joint_velocity: ArrayLike,
        joint_acceleration: ArrayLike,
        contact_force: ArrayLike = (0.0, 0.0, 0.0),
    ) -> Array:
        """Joint torques that produce a motion, by the recursive Newton-Euler algorithm.

        Args:
            joint_position: (..., 3) [rad, m, rad].
            joint_velocity: (..., 3) [rad/s, m/s, rad/s].
            joint_acceleration: (..., 3) [rad/s^2, m/s^2, rad/s^2].
            contact_force: (..., 3) force by the tip on the environment, world frame [N].

        Returns:
            (..., 3) [N m, N, N m].

        Raises:
            ShapeError: an argument does not have three components.

        Source: [S] 7.5.2.
        """
        q, velocity, acceleration, force = broadcast(
            as_vectors(joint_position, "joint_position"),
            as_vectors(joint_velocity, "joint_velocity"),
            as_vectors(joint_acceleration, "joint_acceleration"),
            as_vectors(contact_force, "contact_force"),
        )
        return recursive_newton_euler(self, q, velocity, acceleration, force) + self.friction_force(velocity)

    def operational_space_dynamics(
        self, joint_position: ArrayLike, joint_velocity: ArrayLike
    ) -> OperationalSpaceDynamics:
        """Dynamic model in operational space, without friction.

        Args:
            joint_position: (..., 3) [rad, m, rad].
            joint_velocity: (..., 3) [rad/s, m/s, rad/s].

        Returns:
            Inertia matrix (..., 6, 6), Coriolis and gravity forces (..., 6). J_A has full column rank
            everywhere, so that its pseudoinverse is always defined.

        Raises:
            ShapeError: an argument does not have three components.

        Source: [S] 7.8; [R] 5.1.
        """
        q, velocity = self._state(joint_position, joint_velocity)
        transposed = pseudoinverse_transposed(self.analytical_jacobian(q))
        inertia = multiply(multiply(transposed, self.inertia_matrix(q)), np.swapaxes(transposed, -1, -2))
        coriolis = apply(transposed, apply(self.coriolis_matrix(q, velocity), velocity))
        drift = apply(self.analytical_jacobian_derivative(q, velocity), velocity)
        return OperationalSpaceDynamics(
            inertia, coriolis - apply(inertia, drift), apply(transposed, self.gravity_vector(q))
        )

    def regressor(
        self,
        joint_position: ArrayLike,
        joint_velocity: ArrayLike,
        reference_velocity: ArrayLike,
        reference_acceleration: ArrayLike,
    ) -> Array:
        """Y with B q̈_r + C(q, q̇) q̇_r + F_v q̇_r + F_s sign(q̇_r) + g = Y Θ.

        Args:
            joint_position: (..., 3) [rad, m, rad].
            joint_velocity: (..., 3) [rad/s, m/s, rad/s].
            reference_velocity: q̇_r (..., 3) [rad/s, m/s, rad/s].
            reference_acceleration: q̈_r (..., 3) [rad/s^2, m/s^2, rad/s^2].

        Returns:
            (..., 3, 12); the columns are ordered as in `parameter_vector`.

        Raises:
            ShapeError: an argument does not have three components.

        Source: [S] 7.2.2, 8.5.4.
        """
        q, w, r, a = broadcast(
            as_vectors(joint_position, "joint_position"),
            as_vectors(joint_velocity, "joint_velocity"),
            as_vectors(reference_velocity, "reference_velocity"),
            as_vectors(reference_acceleration, "reference_acceleration"),
        )
        geometry, g = self.parameters.geometry, self.parameters.gravity
        a_1, u = geometry.first_link_offset, q[..., 1] + geometry.slide_offset
        s, c = np.sin(q[..., 2]), np.cos(q[..., 2])
        w_1, v_2, w_3 = w[..., 0], w[..., 1], w[..., 2]
        r_1, r_2, r_3 = r[..., 0], r[..., 1], r[..., 2]
        a_r1, a_r2, a_r3 = a[..., 0], a[..., 1], a[..., 2]
        Y = matrix_like(q, 3, 12)
        Y[..., 0, 0] = a_r1
        Y[..., 0, 1] = u**2 * a_r1 - a_1 * a_r2 + u * (v_2 * r_1 + w_1 * r_2)
        Y[..., 1, 1] = a_r2 - a_1 * a_r1 - u * w_1 * r_1
        Y[..., 0, 2] = -2 * u * a_r1 - (v_2 * r_1 + w_1 * r_2)
        Y[..., 1, 2] = w_1 * r_1
        Y[..., 0, 3] = (
            2 * u * c * a_r1
            + a_1 * s * a_r3
            + c * (v_2 * r_1 + w_1 * r_2)
            - s * u * (w_3 * r_1 + w_1 * r_3)
            + a_1 * c * w_3 * r_3
        )
        Y[..., 1, 3] = -s * a_r3 - c * (w_1 * r_1 + w_3 * r_3)
        Y[..., 2, 3] = a_1 * s * a_r1 - s * a_r2 + s * u * w_1 * r_1 + g * c
        Y[..., 0, 4] = c**2 * a_r1 - s * c * (w_3 * r_1 + w_1 * r_3)
        Y[..., 2, 4] = s * c * w_1 * r_1
        Y[..., 2, 5] = a_r3
        Y[..., [0, 1, 2], [6, 7, 8]] = r
        Y[..., [0, 1, 2], [9, 10, 11]] = np.sign(r)
        return Y

    def parameter_vector(self) -> Array:
        """Θ (12): the six base parameters, then F_v (3) and F_s (3), in the units of their declarations."""
        base = self.base_parameters
        return np.array(
            [
                base.first_axis,
                base.slide_mass,
                base.second_moment,
                base.third_moment,
                base.third_spread,
                base.third_axis,
                *self.parameters.viscous_friction,
                *self.parameters.coulomb_friction,
            ]
        )
