"""Motion of n arms against elastic planes, written out in components: n arms cost little more than one."""

from collections.abc import Sequence
from dataclasses import astuple
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from prp_gym.robot import RobotParameters
from prp_gym.robot.dynamics import BaseParameters
from prp_gym.robot.parameters import ArmGeometry

Array = NDArray[np.float64]
Components = tuple[Array, Array, Array]

STEP = 0.001  # time step of the semi-implicit Euler integration [s]


class ElasticPlane(Protocol):
    """One plane for each arm: the points with normal·p = offset, free where it is more.

    Attributes:
        normal: Unit normals towards the free side (n, 3).
        offset: Offsets along the normals (n) [m].
        stiffness: Stiffness (n) [N/m].
        damping: Damping (n) [N s/m].
    """

    @property
    def normal(self) -> Array: ...

    @property
    def offset(self) -> Array: ...

    @property
    def stiffness(self) -> Array: ...

    @property
    def damping(self) -> Array: ...


class Arms(NamedTuple):
    """Arms of one geometry, whose masses and friction may differ; one for all rows, or one for each.

    Attributes:
        geometry: ArmGeometry of all of them.
        gravity: Gravity of all of them [m/s^2].
        base: Base parameters, (1) or (n) each, in the order of `BaseParameters`.
        viscous_friction: Viscous friction (1 or n, 3).
        coulomb_friction: Coulomb friction (1 or n, 3).
    """

    geometry: ArmGeometry
    gravity: float
    base: Array
    viscous_friction: Array
    coulomb_friction: Array

    @classmethod
    def of(cls, parameters: Sequence[RobotParameters]) -> "Arms":
        """The arms with these parameters."""
        return cls(
            parameters[0].geometry,
            parameters[0].gravity,
            np.array([astuple(BaseParameters.of(one)) for one in parameters]).T,
            np.array([one.viscous_friction for one in parameters]),
            np.array([one.coulomb_friction for one in parameters]),
        )


def advance(
    arms: Arms, q: Array, v: Array, torque: Array, wall: ElasticPlane | None, steps: int
) -> tuple[Array, Array]:
    """Joint positions and velocities (n, 3) some steps later under a constant torque (n, 3)."""
    rough = arms.viscous_friction.any() or arms.coulomb_friction.any()
    for _ in range(steps):
        driving = torque
        if rough:
            driving = torque - arms.viscous_friction * v - arms.coulomb_friction * np.sign(v)
        load = (driving[:, 0], driving[:, 1], driving[:, 2])
        if wall is not None:
            pressed = _wall_torque(arms.geometry, q, v, wall)
            load = (load[0] + pressed[0], load[1] + pressed[1], load[2] + pressed[2])
        v = v + STEP * np.stack(_acceleration(arms, q, v, load), axis=-1)
        q = q + STEP * v
    return q, v


def _wall_torque(geometry: ArmGeometry, q: Array, v: Array, wall: ElasticPlane) -> Components:
    """J^T n times the force, which acts along the normal n."""
    a_1, a_3 = geometry.first_link_offset, geometry.third_link_length
    n_x, n_y, n_z = wall.normal[:, 0], wall.normal[:, 1], wall.normal[:, 2]
    s_1, c_1, s_3, c_3 = np.sin(q[:, 0]), np.cos(q[:, 0]), np.sin(q[:, 2]), np.cos(q[:, 2])
    reach = q[:, 1] + geometry.slide_offset + a_3 * c_3
    along, aside = n_x * s_1 - n_y * c_1, n_x * c_1 + n_y * s_1  # n·(direction of the slide), n·(across it)
    height = geometry.base_height + a_3 * s_3
    depth = wall.offset - reach * along - a_1 * aside - n_z * height
    lever_1, lever_3 = reach * aside - a_1 * along, a_3 * (n_z * c_3 - s_3 * along)
    rate = lever_1 * v[:, 0] + along * v[:, 1] + lever_3 * v[:, 2]
    force = np.maximum(0.0, wall.stiffness * depth - wall.damping * rate) * (depth > 0.0)
    return force * lever_1, force * along, force * lever_3


def _acceleration(arms: Arms, q: Array, v: Array, load: Components) -> Components:
    """q̈ of the arm without friction under a load [N m, N, N m].

    With y = q̈_2 - a_1 q̈_1 the second and third equations contain q̈_1 no more, and the first one plus
    a_1 times the second one contains q̈_1 alone.
    """
    first_axis, m, second, third, spread, third_axis = arms.base
    a_1, u, w_1, w_3 = arms.geometry.first_link_offset, q[:, 1] + arms.geometry.slide_offset, v[:, 0], v[:, 2]
    s_3, c_3 = np.sin(q[:, 2]), np.cos(q[:, 2])
    third_c, third_s = third * c_3, third * s_3
    slide = m * u - second + third_c  # half of ∂B_11/∂q_2
    turn = s_3 * (third * u + spread * c_3)  # minus half of ∂B_11/∂q_3
    swing, spin = third_c * w_3 * w_3, w_1 * w_1
    b_1 = load[0] - 2.0 * w_1 * (slide * v[:, 1] - turn * w_3) - a_1 * swing
    b_2 = load[1] + slide * spin + swing
    b_3 = load[2] - turn * spin - arms.gravity * third_c
    inertia = first_axis + u * (slide - second + third_c) + spread * c_3 * c_3
    first = (b_1 + a_1 * b_2) / (inertia - a_1 * a_1 * m)
    determinant = m * third_axis - third_s * third_s
    relative = (third_axis * b_2 + third_s * b_3) / determinant
    return first, relative + a_1 * first, (m * b_3 + third_s * b_2) / determinant
