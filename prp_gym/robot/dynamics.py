"""Inertia, Coriolis, gravity and energies in closed form over any leading dimensions.

B(q) q̈ + C(q, q̇) q̇ + F_v q̇ + F_s sign(q̇) + g(q) = τ - J^T h_e, with h_e the force of the tip on the
environment. Symbols: u = d̄_2 + q_2; c_i are the distances to the centres of mass.
"""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from prp_gym.robot.arrays import (
    Array,
    apply,
    apply_transposed,
    as_vectors,
    broadcast,
    dot,
    matrix_like,
    solve_symmetric,
    zeros,
)
from prp_gym.robot.motion import MotionConversion
from prp_gym.robot.parameters import NOMINAL, ArmGeometry, RobotParameters


@dataclass(frozen=True)
class BaseParameters:
    """Base parameters: the combinations of masses and inertias in which the dynamics are linear.

    Attributes:
        first_axis: Inertia m_1c_1² + I_1z + (m_2 + m_3)a_1² + I_2z + m_2c_2² + I_3y [kg m^2].
        slide_mass: Mass m_2 + m_3 moved by the slide [kg].
        second_moment: First moment of mass m_2c_2 [kg m].
        third_moment: First moment of mass m_3c_3 [kg m].
        third_spread: Inertia difference m_3c_3² + I_3z - I_3y [kg m^2].
        third_axis: Inertia m_3c_3² + I_3x [kg m^2].
    """

    first_axis: float
    slide_mass: float
    second_moment: float
    third_moment: float
    third_spread: float
    third_axis: float

    @classmethod
    def of(cls, parameters: RobotParameters) -> "BaseParameters":
        """The base parameters of an arm."""
        return cls.of_links(parameters.geometry, parameters.link_mass, parameters.link_inertia)

    @classmethod
    def of_links(cls, geometry: ArmGeometry, link_mass: Any, link_inertia: Any) -> "BaseParameters":
        """The base parameters of one arm or of many.

        Args:
            geometry: geometry of the arm.
            link_mass: masses of the links (3), numbers or arrays (...) [kg].
            link_inertia: inertia of each link about its axes (3, 3), numbers or arrays (...) [kg m^2].
        """
        m_1, m_2, m_3 = link_mass
        (_, _, i_1z), (_, _, i_2z), (i_3x, i_3y, i_3z) = link_inertia
        c_1, c_2 = geometry.first_link_center_of_mass, geometry.second_link_center_of_mass
        c_3, a_1 = geometry.third_link_center_of_mass, geometry.first_link_offset
        return cls(
            first_axis=m_1 * c_1**2 + i_1z + (m_2 + m_3) * a_1**2 + i_2z + m_2 * c_2**2 + i_3y,
            slide_mass=m_2 + m_3,
            second_moment=m_2 * c_2,
            third_moment=m_3 * c_3,
            third_spread=m_3 * c_3**2 + i_3z - i_3y,
            third_axis=m_3 * c_3**2 + i_3x,
        )


class Dynamics(MotionConversion):
    """The closed-form rigid-body model of the arm.

    Attributes:
        joint_count: Number of joints, 3.

    Source: [S] 7.1-7.3; [R] 2-3, with the errors in inertia, Coriolis and gravity terms corrected.
    """

    joint_count: ClassVar[int] = 3

    def __init__(self, parameters: RobotParameters = NOMINAL) -> None:
        super().__init__(parameters)
        self.base_parameters = BaseParameters.of(parameters)
        self._viscous_friction = np.array(parameters.viscous_friction)
        self._coulomb_friction = np.array(parameters.coulomb_friction)

    def inertia_matrix(self, joint_position: ArrayLike) -> Array:
        """B(q), symmetric and positive definite.

        Args:
            joint_position: (..., 3) [rad, m, rad].

        Returns:
            (..., 3, 3) [kg m^2, kg m, kg m^2; kg m, kg, kg m; kg m^2, kg m, kg m^2].

        Raises:
            ShapeError: an argument does not have three components.
        """
        q = as_vectors(joint_position, "joint_position")
        base, a_1 = self.base_parameters, self.parameters.geometry.first_link_offset
        u = q[..., 1] + self.parameters.geometry.slide_offset
        s_3, c_3 = np.sin(q[..., 2]), np.cos(q[..., 2])
        B = matrix_like(q, 3, 3)
        B[..., 0, 0] = (
            base.first_axis
            + u * (base.slide_mass * u - 2 * base.second_moment + 2 * base.third_moment * c_3)
            + base.third_spread * c_3**2
        )
        B[..., 0, 1] = B[..., 1, 0] = -a_1 * base.slide_mass
        B[..., 0, 2] = B[..., 2, 0] = a_1 * base.third_moment * s_3
        B[..., 1, 1] = base.slide_mass
        B[..., 1, 2] = B[..., 2, 1] = -base.third_moment * s_3
        B[..., 2, 2] = base.third_axis
        return B

    def coriolis_matrix(self, joint_position: ArrayLike, joint_velocity: ArrayLike) -> Array:
        """C(q, q̇) from Christoffel symbols of the first kind, so that Ḃ - 2C is skew-symmetric.

        Args:
            joint_position: (..., 3) [rad, m, rad].
            joint_velocity: (..., 3) [rad/s, m/s, rad/s].

        Returns:
            (..., 3, 3) [units of B per second].

        Raises:
            ShapeError: an argument does not have three components.
        """
        return self._coriolis(*self._state(joint_position, joint_velocity))

    def _coriolis(self, q: Array, velocity: Array) -> Array:
        base, a_1 = self.base_parameters, self.parameters.geometry.first_link_offset
        u = q[..., 1] + self.parameters.geometry.slide_offset
        s_3, c_3 = np.sin(q[..., 2]), np.cos(q[..., 2])
        w_1, v_2, w_3 = velocity[..., 0], velocity[..., 1], velocity[..., 2]
        half_slide = base.slide_mass * u - base.second_moment + base.third_moment * c_3
        half_third = -s_3 * (base.third_moment * u + base.third_spread * c_3)
        C = matrix_like(q, 3, 3)
        C[..., 0, 0] = half_slide * v_2 + half_third * w_3
        C[..., 0, 1] = half_slide * w_1
        C[..., 0, 2] = half_third * w_1 + a_1 * base.third_moment * c_3 * w_3
        C[..., 1, 0] = -half_slide * w_1
        C[..., 1, 2] = -base.third_moment * c_3 * w_3
        C[..., 2, 0] = -half_third * w_1
        return C

    def gravity_vector(self, joint_position: ArrayLike) -> Array:
        """g(q) = ∂U/∂q.

        Args:
            joint_position: (..., 3) [rad, m, rad].

        Returns:
            (..., 3) [N m, N, N m].

        Raises:
            ShapeError: an argument does not have three components.
        """
        return self._gravity(as_vectors(joint_position, "joint_position"))

    def _gravity(self, q: Array) -> Array:
        gravity = zeros(q.shape, q)
        gravity[..., 2] = self.base_parameters.third_moment * self.parameters.gravity * np.cos(q[..., 2])
        return gravity

    def friction_force(self, joint_velocity: ArrayLike) -> Array:
        """F_v q̇ + F_s sign(q̇).

        Args:
            joint_velocity: (..., 3) [rad/s, m/s, rad/s].

        Returns:
            (..., 3) [N m, N, N m].

        Raises:
            ShapeError: an argument does not have three components.
        """
        return self._friction(as_vectors(joint_velocity, "joint_velocity"))

    def _friction(self, velocity: Array) -> Array:
        friction: Array = self._viscous_friction * velocity + self._coulomb_friction * np.sign(velocity)
        return friction

    def bias_force(self, joint_position: ArrayLike, joint_velocity: ArrayLike) -> Array:
        """n(q, q̇) = C(q, q̇) q̇ + F_v q̇ + F_s sign(q̇) + g(q).

        Args:
            joint_position: (..., 3) [rad, m, rad].
            joint_velocity: (..., 3) [rad/s, m/s, rad/s].

        Returns:
            (..., 3) [N m, N, N m].

        Raises:
            ShapeError: an argument does not have three components.
        """
        q, velocity = self._state(joint_position, joint_velocity)
        return apply(self._coriolis(q, velocity), velocity) + self._friction(velocity) + self._gravity(q)

    def forward_dynamics(
        self,
        joint_position: ArrayLike,
        joint_velocity: ArrayLike,
        torque: ArrayLike,
        contact_force: ArrayLike = (0.0, 0.0, 0.0),
    ) -> Array:
        """Joint accelerations q̈ = B^-1 (τ - n - J^T h_e).

        Args:
            joint_position: (..., 3) [rad, m, rad].
            joint_velocity: (..., 3) [rad/s, m/s, rad/s].
            torque: (..., 3) [N m, N, N m].
            contact_force: (..., 3) force by the tip on the environment, world frame [N].

        Returns:
            (..., 3) [rad/s^2, m/s^2, rad/s^2].

        Raises:
            ShapeError: an argument does not have three components.
        """
        q, velocity = self._state(joint_position, joint_velocity)
        force = as_vectors(contact_force, "contact_force")
        J = self.analytical_jacobian(q)[..., :3, :]
        right = as_vectors(torque, "torque") - self.bias_force(q, velocity) - apply_transposed(J, force)
        return solve_symmetric(self.inertia_matrix(q), right)

    def kinetic_energy(self, joint_position: ArrayLike, joint_velocity: ArrayLike) -> Array:
        """T = ½ q̇^T B(q) q̇.

        Args:
            joint_position: (..., 3) [rad, m, rad].
            joint_velocity: (..., 3) [rad/s, m/s, rad/s].

        Returns:
            (...) [J].

        Raises:
            ShapeError: an argument does not have three components.
        """
        q, velocity = self._state(joint_position, joint_velocity)
        return 0.5 * dot(velocity, apply(self.inertia_matrix(q), velocity))

    def potential_energy(self, joint_position: ArrayLike) -> Array:
        """U = Σ m_i g z_i, zero if all masses were on the floor.

        Args:
            joint_position: (..., 3) [rad, m, rad].

        Returns:
            (...) [J].

        Raises:
            ShapeError: an argument does not have three components.
        """
        q = as_vectors(joint_position, "joint_position")
        height = self.parameters.geometry.base_height
        level = sum(self.parameters.link_mass) * height
        energy: Array = self.parameters.gravity * (
            level + self.base_parameters.third_moment * np.sin(q[..., 2])
        )
        return energy

    def _state(self, joint_position: ArrayLike, joint_velocity: ArrayLike) -> tuple[Array, Array]:
        q = as_vectors(joint_position, "joint_position")
        velocity = as_vectors(joint_velocity, "joint_velocity")
        q, velocity = broadcast(q, velocity)
        return q, velocity
