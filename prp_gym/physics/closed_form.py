"""The arm's simulation in closed form: MuJoCo's semi-implicit Euler steps as formulas over leading axes.

Friction, joint stops and the surface are MuJoCo's soft constraints: the acceleration a minimises
½ (a - a_0)ᵀ B (a - a_0) + Σ s_i(J_i a - r_i), with the acceleration a_0 = B⁻¹b without constraints, a row J_i
and the reference r_i of each constraint, and s_i(z) = ½ D_i z² on one side of zero for a stop or the surface,
and with slope ±loss beyond a band for Coulomb friction.

Source: [M] Computation, Constraint model.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from prp_gym.physics.surface import IMPEDANCE
from prp_gym.robot.arm import PRPArm
from prp_gym.robot.arrays import Array, dot, matrix_like, solve_symmetric
from prp_gym.robot.dynamics import BaseParameters
from prp_gym.robot.parameters import NOMINAL

_STOP_TIME, _STOP_DAMPING_RATIO = 0.004, 1.0  # solreflimit of the MJCF document
_STOP_IMPEDANCE, _STOP_LARGEST, _STOP_WIDTH = 0.95, 0.99, 0.001  # solimplimit
_FRICTION_TIME = 0.02  # MuJoCo's default solreffriction
_FRICTION_IMPEDANCE, _FRICTION_LARGEST = 0.9, 0.95  # MuJoCo's default solimpfriction


class PlantArm(PRPArm):
    """Arms of the nominal geometry with other masses and friction, one for each leading index.

    Args:
        base_parameters: base parameters, arrays (...).
        viscous_friction: F_v (..., 3) [N m s/rad, N s/m, N m s/rad]; Coulomb friction is a constraint here.
    """

    def __init__(self, base_parameters: BaseParameters, viscous_friction: Array) -> None:
        super().__init__(NOMINAL)
        self.base_parameters = base_parameters
        self._viscous_friction = viscous_friction
        self._coulomb_friction = np.zeros(3)


class SurfaceRows(NamedTuple):
    """The surfaces of N simulations, as they are now.

    Attributes:
        stiffness: K (...) [N/m].
        damping: D (...) [N s/m].
        point: a point of the plane (..., 3), world frame [m].
        velocity: velocity of the surface (..., 3), world frame [m/s].
        normal: unit vector (..., 3) to the free side, world frame.
    """

    stiffness: Array
    damping: Array
    point: Array
    velocity: Array
    normal: Array


class Rows(NamedTuple):
    """Constraints of one kind.

    Attributes:
        jacobian: rows J_i (..., n, 3).
        reference: reference accelerations r_i (..., n).
        weight: D_i (..., n), zero for a constraint that is not active.
    """

    jacobian: Array
    reference: Array
    weight: Array


@dataclass(frozen=True, eq=False)
class ClosedForm:
    """N arms, each with its own masses and friction.

    Attributes:
        arm: arm whose base parameters and viscous friction are those of the plants, (...) each.
        viscous_friction: F_v (..., 3) [N m s/rad, N s/m, N m s/rad].
        joint_inverse_weight: MuJoCo's `dof_invweight0` (..., 3), diag B⁻¹ at q = 0.
        tip_inverse_weight: MuJoCo's `body_invweight0` (...) of the third link [1/kg].
        timestep: duration h of a step [s].
    """

    arm: PlantArm
    viscous_friction: Array
    joint_inverse_weight: Array
    tip_inverse_weight: Array
    timestep: float

    def unconstrained(self, q: Array, velocity: Array, torque: Array) -> tuple[Array, Array]:
        """B (..., 3, 3) and b = τ - n (..., 3): a_0 = B⁻¹b is the acceleration without constraints."""
        return self.arm.inertia_matrix(q), torque - self.arm.bias_force(q, velocity)

    def surface_row(self, q: Array, velocity: Array, surface: SurfaceRows) -> Rows:
        """The constraint of the surface, one row; it is active below the surface."""
        J = self.arm.geometric_jacobian(q)[..., :3, :]
        tip = self.arm.forward_kinematics(q)[..., :3]
        along = dot(surface.normal[..., None, :], J.mT)
        depth = dot(surface.normal, surface.point - tip)
        rate = dot(surface.normal, surface.velocity) - dot(along, velocity)
        reference = (
            self.tip_inverse_weight
            * (1.0 - IMPEDANCE)
            / IMPEDANCE
            * (surface.stiffness * depth + surface.damping * rate)
        )
        weight = IMPEDANCE / ((1.0 - IMPEDANCE) * self.tip_inverse_weight)
        weight = np.where(depth >= 0.0, weight, 0.0)
        return Rows(along[..., None, :], reference[..., None], weight[..., None])

    def stop_rows(self, q: Array, velocity: Array) -> Rows:
        """The constraints of the joint stops (3): the nearer stop of each joint; active beyond it."""
        low, high = np.array(self.arm.parameters.joint_lower), np.array(self.arm.parameters.joint_upper)
        inward = np.where(q - low < high - q, 1.0, -1.0)
        distance = np.where(q - low < high - q, q - low, high - q)
        share = np.minimum(np.abs(distance) / _STOP_WIDTH, 1.0)
        rising = np.where(share < 0.5, 2.0 * share * share, 1.0 - 2.0 * (1.0 - share) * (1.0 - share))
        impedance = _STOP_IMPEDANCE + rising * (_STOP_LARGEST - _STOP_IMPEDANCE)
        spring = 1.0 / (_STOP_LARGEST * _STOP_TIME * _STOP_DAMPING_RATIO) ** 2
        damper = 2.0 / (_STOP_LARGEST * _STOP_TIME)
        reference = -damper * inward * velocity - spring * impedance * distance
        weight = impedance / ((1.0 - impedance) * self.joint_inverse_weight)
        return Rows(_diagonal(inward), reference, np.where(distance < 0.0, weight, 0.0))

    def friction_rows(self, q: Array, velocity: Array) -> Rows:
        """The constraints of the joints' Coulomb friction (3), always active."""
        damper = 2.0 / (_FRICTION_LARGEST * _FRICTION_TIME)
        weight = _FRICTION_IMPEDANCE / ((1.0 - _FRICTION_IMPEDANCE) * self.joint_inverse_weight)
        return Rows(_diagonal(np.ones(3) + 0.0 * q), -damper * velocity, weight)

    def advanced(self, q: Array, velocity: Array, B: Array, force: Array) -> tuple[Array, Array]:
        """Joint position and velocity (..., 3) a step later.

        Args:
            q: joint position (..., 3) [rad, m, rad].
            velocity: joint velocity (..., 3) per second.
            B: inertia matrix (..., 3, 3).
            force: b plus the forces of the constraints in the joints (..., 3) [N m, N, N m].
        """
        implicit = B + self.timestep * _diagonal(self.viscous_friction)
        velocity = velocity + self.timestep * solve_symmetric(implicit, force)
        return q + self.timestep * velocity, velocity


def surface_force(B: Array, b: Array, row: Rows) -> Array:
    """The force of the surface (...) [N] where no other constraint is active.

    Args:
        B: inertia matrix (..., 3, 3).
        b: τ - n (..., 3).
        row: constraint of the surface, one row.
    """
    J, weight = row.jacobian[..., 0, :], row.weight[..., 0]
    missing = row.reference[..., 0] - dot(J, solve_symmetric(B, b))
    inverse_mass = dot(J, solve_symmetric(B, J))
    return np.maximum(weight * missing / (1.0 + weight * inverse_mass), 0.0)


def _diagonal(values: Array) -> Array:
    """Diagonal matrices (..., 3, 3) of their diagonals (..., 3)."""
    matrix = matrix_like(values, 3, 3)
    for index in range(3):
        matrix[..., index, index] = values[..., index]
    return matrix
