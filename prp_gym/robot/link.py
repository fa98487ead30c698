"""The link: one joint under gravity, whose three parameters adaptive control estimates.

I q̈ + F q̇ + G sin q = τ, with q = 0 where the link hangs down.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from prp_gym.checks import components, within
from prp_gym.errors import InvalidValueError
from prp_gym.robot.arrays import Array, as_vectors, broadcast, matrix_like

_INERTIAS = (1e-15, 1e15)  # [kg m^2]
_MOMENTS = (0.0, 1e12)
_TORQUES = (1e-9, 1e12)  # [N m]


@dataclass(frozen=True)
class LinkParameters:
    """Parameters of the link; the defaults are the report's.

    Attributes:
        inertia: Moment of inertia I about the joint's axis [kg m^2].
        viscous_friction: Coefficient F of the viscous friction [N m s/rad].
        gravity_moment: G, the largest moment of the weight about the joint's axis [N m].
        torque_limit: Actuator limit (1) [N m].

    Raises:
        InvalidValueError: a value that is not a number or is out of bounds.
        ShapeError: several numbers in place of one.

    Source: [R] 8.1, except the torque limit, which is this suite's own.
    """

    inertia: float = 0.5
    viscous_friction: float = 0.15
    gravity_moment: float = 1.85
    torque_limit: tuple[float] = (30.0,)

    def __post_init__(self) -> None:
        for name, bounds, unit in (
            ("inertia", _INERTIAS, "kg·m²"),
            ("viscous_friction", _MOMENTS, "N·m·s/rad"),
            ("gravity_moment", _MOMENTS, "N·m"),
        ):
            object.__setattr__(self, name, within(name, getattr(self, name), bounds, unit))
        limit = components("torque_limit", self.torque_limit, 1, _TORQUES, "N·m")
        object.__setattr__(self, "torque_limit", limit)


NOMINAL_LINK = LinkParameters()


@dataclass(frozen=True)
class Link:
    """The closed-form model of the link; its methods are those of `PRPArm`, for one joint.

    Every method broadcasts over the leading dimensions of its arguments and never modifies them.

    Attributes:
        parameters: Parameters of the link; the report's by default.
        joint_count: Number of joints, 1.

    Raises:
        InvalidValueError: parameters of another kind.

    Source: [R] 8.1.
    """

    parameters: LinkParameters = NOMINAL_LINK
    joint_count: ClassVar[int] = 1

    def __post_init__(self) -> None:
        if not isinstance(self.parameters, LinkParameters):
            raise InvalidValueError("parameters", self.parameters, "a LinkParameters")

    def inertia_matrix(self, joint_position: ArrayLike) -> Array:
        """B = I, which does not depend on the position.

        Args:
            joint_position: (..., 1) [rad].

        Returns:
            (..., 1, 1) [kg m^2].

        Raises:
            ShapeError: an argument does not have one component.
        """
        B = matrix_like(as_vectors(joint_position, "joint_position", 1), 1, 1)
        B[...] = self.parameters.inertia
        return B

    def coriolis_matrix(self, joint_position: ArrayLike, joint_velocity: ArrayLike) -> Array:
        """C = 0: a single joint has no Coriolis or centrifugal moment.

        Args:
            joint_position: (..., 1) [rad].
            joint_velocity: (..., 1) [rad/s].

        Returns:
            (..., 1, 1) [kg m^2/s].

        Raises:
            ShapeError: an argument does not have one component.
        """
        return matrix_like(self._state(joint_position, joint_velocity)[0], 1, 1)

    def gravity_vector(self, joint_position: ArrayLike) -> Array:
        """g(q) = G sin q.

        Args:
            joint_position: (..., 1) [rad].

        Returns:
            (..., 1) [N m].

        Raises:
            ShapeError: an argument does not have one component.
        """
        gravity: Array = self.parameters.gravity_moment * np.sin(
            as_vectors(joint_position, "joint_position", 1)
        )
        return gravity

    def friction_force(self, joint_velocity: ArrayLike) -> Array:
        """F q̇.

        Args:
            joint_velocity: (..., 1) [rad/s].

        Returns:
            (..., 1) [N m].

        Raises:
            ShapeError: an argument does not have one component.
        """
        return self.parameters.viscous_friction * as_vectors(joint_velocity, "joint_velocity", 1)

    def bias_force(self, joint_position: ArrayLike, joint_velocity: ArrayLike) -> Array:
        """n(q, q̇) = F q̇ + G sin q.

        Args:
            joint_position: (..., 1) [rad].
            joint_velocity: (..., 1) [rad/s].

        Returns:
            (..., 1) [N m].

        Raises:
            ShapeError: an argument does not have one component.
        """
        return self.friction_force(joint_velocity) + self.gravity_vector(joint_position)

    def forward_dynamics(
        self, joint_position: ArrayLike, joint_velocity: ArrayLike, torque: ArrayLike
    ) -> Array:
        """Joint acceleration caused by a torque.

        Args:
            joint_position: (..., 1) [rad].
            joint_velocity: (..., 1) [rad/s].
            torque: (..., 1) [N m].

        Returns:
            (..., 1) [rad/s^2].

        Raises:
            ShapeError: an argument does not have one component.
        """
        surplus = as_vectors(torque, "torque", 1) - self.bias_force(joint_position, joint_velocity)
        return surplus / self.parameters.inertia

    def kinetic_energy(self, joint_position: ArrayLike, joint_velocity: ArrayLike) -> Array:
        """T = ½ I q̇².

        Args:
            joint_position: (..., 1) [rad].
            joint_velocity: (..., 1) [rad/s].

        Returns:
            (...) [J].

        Raises:
            ShapeError: an argument does not have one component.
        """
        _, velocity = self._state(joint_position, joint_velocity)
        energy: Array = 0.5 * self.parameters.inertia * velocity[..., 0] ** 2
        return energy

    def potential_energy(self, joint_position: ArrayLike) -> Array:
        """U = G (1 - cos q), zero where the link hangs down.

        Args:
            joint_position: (..., 1) [rad].

        Returns:
            (...) [J].

        Raises:
            ShapeError: an argument does not have one component.
        """
        q = as_vectors(joint_position, "joint_position", 1)
        energy: Array = self.parameters.gravity_moment * (1.0 - np.cos(q[..., 0]))
        return energy

    def regressor(
        self,
        joint_position: ArrayLike,
        joint_velocity: ArrayLike,
        reference_velocity: ArrayLike,
        reference_acceleration: ArrayLike,
    ) -> Array:
        """Y with I q̈_r + F q̇_r + G sin q = Y Θ.

        Args:
            joint_position: (..., 1) [rad].
            joint_velocity: (..., 1) [rad/s]; the result does not depend on it.
            reference_velocity: q̇_r (..., 1) [rad/s].
            reference_acceleration: q̈_r (..., 1) [rad/s^2].

        Returns:
            (..., 1, 3): columns q̈_r, q̇_r, sin q, as in `parameter_vector`.

        Raises:
            ShapeError: an argument does not have one component.

        Source: [S] 8.5.4; [R] 8.1, which uses measured instead of reference values.
        """
        q, _, velocity, acceleration = broadcast(
            as_vectors(joint_position, "joint_position", 1),
            as_vectors(joint_velocity, "joint_velocity", 1),
            as_vectors(reference_velocity, "reference_velocity", 1),
            as_vectors(reference_acceleration, "reference_acceleration", 1),
        )
        return np.stack([acceleration, velocity, np.sin(q)], axis=-1)

    def parameter_vector(self) -> Array:
        """Θ = (I, F, G) (3) [kg m^2, N m s/rad, N m]."""
        own = self.parameters
        return np.array([own.inertia, own.viscous_friction, own.gravity_moment])

    def _state(self, joint_position: ArrayLike, joint_velocity: ArrayLike) -> tuple[Array, Array]:
        q, velocity = broadcast(
            as_vectors(joint_position, "joint_position", 1), as_vectors(joint_velocity, "joint_velocity", 1)
        )
        return q, velocity
