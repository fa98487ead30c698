"""Forward kinematics and Jacobians, in closed form over any leading dimensions.

Symbols: S_i = sin q_i, C_i = cos q_i, L = q_2 + d̄_2 + a_3 C_3. World frame: z up, joint 1's axis is z.
"""

import math
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from prp_gym.errors import InvalidValueError
from prp_gym.robot.arrays import Array, as_vectors, broadcast, matrix_like, multiply, zeros
from prp_gym.robot.components import components, from_components, sine_and_cosine
from prp_gym.robot.parameters import NOMINAL, RobotParameters


class _Trigonometry(NamedTuple):
    """Sines, cosines and reach of joint positions: arrays (...), of a single position numbers."""

    sin_1: Any
    cos_1: Any
    sin_3: Any
    cos_3: Any
    reach: Any


class Kinematics:
    """Forward kinematics and Jacobians of the arm.

    Args:
        parameters: Parameters of the arm; only their geometry is read.

    Raises:
        InvalidValueError: parameters of another kind.

    Source: [S] 2.8, 3.1, 3.6; [R] 1.
    """

    def __init__(self, parameters: RobotParameters = NOMINAL) -> None:
        if not isinstance(parameters, RobotParameters):
            raise InvalidValueError("parameters", parameters, "a RobotParameters")
        self.parameters = parameters

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other) and self.parameters == vars(other)["parameters"]

    def __hash__(self) -> int:
        return hash((type(self), self.parameters))

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.parameters!r})"

    @cached_property
    def joint_limits(self) -> tuple[Array, Array]:
        """The lower and the upper joint limits (3) [rad, m, rad]."""
        return np.array(self.parameters.joint_lower), np.array(self.parameters.joint_upper)

    def _trigonometry(self, q: Array) -> _Trigonometry:
        geometry, (q_1, q_2, q_3) = self.parameters.geometry, components(q)
        sin_3, cos_3 = sine_and_cosine(q_3)
        reach = q_2 + geometry.slide_offset + geometry.third_link_length * cos_3
        return _Trigonometry(*sine_and_cosine(q_1), sin_3, cos_3, reach)

    def forward_kinematics(self, joint_position: ArrayLike) -> Array:
        """Pose of the end effector.

        Args:
            joint_position: (..., 3) [rad, m, rad].

        Returns:
            (..., 6): tip position in the world frame [m], ZXZ Euler angles α, β, γ [rad], with
            α = q_1, β = π/2 - q_3, γ = π/2.

        Raises:
            ShapeError: an argument does not have three components.

        Source: [R] 1.2, 1.3.
        """
        q = as_vectors(joint_position, "joint_position")
        return self._pose(q, self._trigonometry(q))

    def _pose(self, q: Array, trig: _Trigonometry) -> Array:
        geometry, (q_1, _, q_3) = self.parameters.geometry, components(q)
        pose = {
            0: trig.reach * trig.sin_1 + geometry.first_link_offset * trig.cos_1,
            1: -trig.reach * trig.cos_1 + geometry.first_link_offset * trig.sin_1,
            2: geometry.base_height + geometry.third_link_length * trig.sin_3,
            3: q_1,
            4: math.pi / 2 - q_3,
            5: math.pi / 2,
        }
        return from_components(pose, (6,), q)

    def reach(self, joint_position: ArrayLike) -> Array:
        """L = q_2 + d̄_2 + a_3 C_3, the distance of the tip from joint 1's axis along the slide.

        Args:
            joint_position: (..., 3) [rad, m, rad].

        Returns:
            (...) [m].

        Raises:
            ShapeError: an argument does not have three components.

        Source: [R] 1.3.
        """
        q = as_vectors(joint_position, "joint_position")
        return from_components({0: self._trigonometry(q).reach}, (), q)

    def transforms(self, joint_position: ArrayLike) -> Array:
        """All Denavit-Hartenberg frames, expressed in the world frame.

        Args:
            joint_position: (..., 3) [rad, m, rad].

        Returns:
            (..., 5, 4, 4): homogeneous transforms of frames 0 (joint 1), 1, 2, 3 and 4 (end effector);
            translations in [m].

        Raises:
            ShapeError: an argument does not have three components.

        Source: [S] 2.8.2; the table in [R] 1.1.
        """
        q = as_vectors(joint_position, "joint_position")
        frames = zeros((*q.shape[:-1], 5, 4, 4), q)
        current = np.broadcast_to(np.eye(4), (*q.shape[:-1], 4, 4))
        for index, link in enumerate(self._denavit_hartenberg_rows(q)):
            current = multiply(current, link)
            frames[..., index, :, :] = current
        return frames

    def _denavit_hartenberg_rows(self, q: Array) -> list[Array]:
        geometry = self.parameters.geometry
        zero = np.zeros(q.shape[:-1])
        right = zero + math.pi / 2
        slide = geometry.slide_offset + q[..., 1]
        table = (
            (0.0, 0.0, zero + geometry.base_height, zero),
            (geometry.first_link_offset, math.pi / 2, zero, q[..., 0]),
            (0.0, -math.pi / 2, slide, right),
            (geometry.third_link_length, 0.0, zero, q[..., 2] - math.pi / 2),
            (0.0, math.pi / 2, zero, right),
        )
        return [_denavit_hartenberg_transform(*row) for row in table]

    def analytical_jacobian(self, joint_position: ArrayLike) -> Array:
        """J_A with ẋ = J_A q̇ for the pose x of `forward_kinematics`.

        Args:
            joint_position: (..., 3) [rad, m, rad].

        Returns:
            (..., 6, 3), rows as in the pose, columns as the joints [m/rad, 1, m/rad; 1, rad/m, 1].
            Full column rank everywhere; its position part is singular at q_3 = ±π/2 and at L = 0.

        Raises:
            ShapeError: an argument does not have three components.

        Source: [S] 3.6; [R] 1.4.
        """
        q = as_vectors(joint_position, "joint_position")
        return self._jacobian(q, self._trigonometry(q))

    def _jacobian(self, q: Array, trig: _Trigonometry) -> Array:
        return from_components(self._jacobian_entries(trig), (6, 3), q)

    def _jacobian_entries(self, trig: _Trigonometry) -> dict[int, Any]:
        """The entries of J_A (6, 3), by position in the flattened matrix."""
        return self._linear_rows(trig) | {9: 1.0, 14: -1.0}

    def geometric_jacobian(self, joint_position: ArrayLike) -> Array:
        """J_G with (ṗ, ω) = J_G q̇; the linear rows equal those of J_A.

        Args:
            joint_position: (..., 3) [rad, m, rad].

        Returns:
            (..., 6, 3): linear rows [m/rad, 1, m/rad], then angular rows, both in the world frame.

        Raises:
            ShapeError: an argument does not have three components.

        Source: [S] 3.1; [R] 1.5.
        """
        q = as_vectors(joint_position, "joint_position")
        trig = self._trigonometry(q)
        turning = {11: -trig.cos_1, 14: -trig.sin_1, 15: 1.0}
        return from_components(self._linear_rows(trig) | turning, (6, 3), q)

    def _linear_rows(self, trig: _Trigonometry) -> dict[int, Any]:
        """The entries of a Jacobian (6, 3) for the tip position, by position in the flattened matrix."""
        a_1, a_3 = self.parameters.geometry.first_link_offset, self.parameters.geometry.third_link_length
        return {
            0: trig.reach * trig.cos_1 - a_1 * trig.sin_1,
            1: trig.sin_1,
            2: -a_3 * trig.sin_1 * trig.sin_3,
            3: trig.reach * trig.sin_1 + a_1 * trig.cos_1,
            4: -trig.cos_1,
            5: a_3 * trig.cos_1 * trig.sin_3,
            8: a_3 * trig.cos_3,
        }

    def analytical_jacobian_derivative(self, joint_position: ArrayLike, joint_velocity: ArrayLike) -> Array:
        """Time derivative of J_A along a motion: ẍ = J_A q̈ + J̇_A q̇.

        Args:
            joint_position: (..., 3) [rad, m, rad].
            joint_velocity: (..., 3) [rad/s, m/s, rad/s].

        Returns:
            (..., 6, 3), [units of J_A per second]; the angular rows are zero.

        Raises:
            ShapeError: an argument does not have three components.

        Source: derivative of [R] 1.4 (its printed J̇_A has misplaced dots).
        """
        q = as_vectors(joint_position, "joint_position")
        velocity = as_vectors(joint_velocity, "joint_velocity")
        q, velocity = broadcast(q, velocity)
        return self._jacobian_derivative(velocity, self._trigonometry(q))

    def _jacobian_derivative(self, velocity: Array, trig: _Trigonometry) -> Array:
        return from_components(self._derivative_entries(components(velocity), trig), (6, 3), velocity)

    def _derivative_entries(self, velocity: list[Any], trig: _Trigonometry) -> dict[int, Any]:
        """The entries of J̇_A (6, 3), by position in the flattened matrix."""
        a_1, a_3 = self.parameters.geometry.first_link_offset, self.parameters.geometry.third_link_length
        s_1, c_1, s_3, c_3, reach = trig
        w_1, v_2, w_3 = velocity
        reach_rate = v_2 - a_3 * s_3 * w_3
        return {
            0: reach_rate * c_1 - (reach * s_1 + a_1 * c_1) * w_1,
            1: c_1 * w_1,
            2: -a_3 * (c_1 * s_3 * w_1 + s_1 * c_3 * w_3),
            3: reach_rate * s_1 + (reach * c_1 - a_1 * s_1) * w_1,
            4: s_1 * w_1,
            5: a_3 * (c_1 * c_3 * w_3 - s_1 * s_3 * w_1),
            8: -a_3 * s_3 * w_3,
        }

    def euler_rate_map(self, joint_position: ArrayLike) -> Array:
        """T_A with J_G = T_A J_A, for the arm's constant γ.

        Args:
            joint_position: (..., 3) [rad, m, rad].

        Returns:
            (..., 6, 6); it maps (ṗ, α̇, β̇, γ̇) to (ṗ, ω) for all motions of the arm. Its rank is 5:
            the γ column is zero, since γ is constant.

        Raises:
            ShapeError: an argument does not have three components.

        Source: [R] 1.6.
        """
        q = as_vectors(joint_position, "joint_position")
        T_A = matrix_like(q, 6, 6)
        T_A[..., [0, 1, 2], [0, 1, 2]] = 1.0
        T_A[..., 3, 4] = np.cos(q[..., 0])
        T_A[..., 4, 4] = np.sin(q[..., 0])
        T_A[..., 5, 3] = 1.0
        return T_A


def _denavit_hartenberg_transform(a: float, alpha: float, d: Array, theta: Array) -> Array:
    """T_{i-1}^i of one row of the Denavit-Hartenberg table, (..., 4, 4)."""
    sine, cosine = np.sin(theta), np.cos(theta)
    sin_alpha, cos_alpha = math.sin(alpha), math.cos(alpha)
    transform = zeros((*theta.shape, 4, 4), theta)
    transform[..., 0, 0], transform[..., 0, 1] = cosine, -sine * cos_alpha
    transform[..., 0, 2], transform[..., 0, 3] = sine * sin_alpha, a * cosine
    transform[..., 1, 0], transform[..., 1, 1] = sine, cosine * cos_alpha
    transform[..., 1, 2], transform[..., 1, 3] = -cosine * sin_alpha, a * sine
    transform[..., 2, 1], transform[..., 2, 2], transform[..., 2, 3] = sin_alpha, cos_alpha, d
    transform[..., 3, 3] = 1.0
    return transform
