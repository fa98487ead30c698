"""Recursive Newton-Euler inverse dynamics, independent of the closed form."""

import numpy as np

from prp_gym.robot.arrays import Array, apply, dot, multiply
from prp_gym.robot.kinematics import Kinematics

_PRISMATIC = (False, True, False)


def recursive_newton_euler(
    kinematics: Kinematics, q: Array, velocity: Array, acceleration: Array, tip_force: Array
) -> Array:
    """Joint torques that produce a motion, without friction.

    All vectors are resolved in the world frame. The outward sweep gives the motion of every frame and
    centre of mass, the inward sweep the forces and moments between the links; gravity enters as an
    upward acceleration of the base.

    Args:
        kinematics: Kinematics of the arm; masses and inertias are read from its parameters.
        q: (..., 3) [rad, m, rad].
        velocity: (..., 3) [rad/s, m/s, rad/s].
        acceleration: (..., 3) [rad/s^2, m/s^2, rad/s^2].
        tip_force: (..., 3) force of the tip on the environment, in the world frame [N].

    Returns:
        (..., 3) [N m, N, N m].

    Source: [S] 7.5.2.
    """
    frames = kinematics.transforms(q)[..., :4, :, :]
    rotation, origin = frames[..., :3, :3], frames[..., :3, 3]
    axis = rotation[..., :3, :, 2]
    force, moment = _link_wrenches(kinematics, frames, axis, velocity, acceleration)
    torque = np.empty(q.shape)
    carried_force, carried_moment = tip_force, np.zeros(tip_force.shape)
    for link in (2, 1, 0):
        arm = origin[..., link + 1, :] - origin[..., link, :]
        carried_moment = moment[link] + carried_moment + np.cross(arm, carried_force)
        carried_force = force[link] + carried_force
        along = carried_force if _PRISMATIC[link] else carried_moment
        torque[..., link] = dot(axis[..., link, :], along)
    return torque


def _link_wrenches(
    kinematics: Kinematics, frames: Array, axis: Array, velocity: Array, acceleration: Array
) -> tuple[list[Array], list[Array]]:
    """For each link, the force that accelerates it and its moment about the link's joint origin."""
    parameters = kinematics.parameters
    offsets, inertias = _in_denavit_hartenberg_frames(kinematics)
    spin = np.zeros((*velocity.shape[:-1], 3))
    spin_rate = np.zeros_like(spin)
    linear = np.zeros_like(spin) + np.array([0.0, 0.0, parameters.gravity])
    forces, moments = [], []
    for link in range(3):
        z, rate, rate_of_rate = axis[..., link, :], velocity[..., link, None], acceleration[..., link, None]
        sliding = np.zeros_like(spin)
        if _PRISMATIC[link]:
            sliding = rate_of_rate * z + 2 * rate * np.cross(spin, z)
        else:
            spin_rate = spin_rate + rate_of_rate * z + rate * np.cross(spin, z)
            spin = spin + rate * z
        arm = frames[..., link + 1, :3, 3] - frames[..., link, :3, 3]
        linear = linear + sliding + np.cross(spin_rate, arm) + np.cross(spin, np.cross(spin, arm))
        rotation = frames[..., link + 1, :3, :3]
        to_center = apply(rotation, offsets[link])
        center = linear + np.cross(spin_rate, to_center) + np.cross(spin, np.cross(spin, to_center))
        inertia = multiply(multiply(rotation, inertias[link]), np.swapaxes(rotation, -1, -2))
        force = parameters.link_mass[link] * center
        spinning = apply(inertia, spin_rate) + np.cross(spin, apply(inertia, spin))
        forces.append(force)
        moments.append(np.cross(arm + to_center, force) + spinning)
    return forces, moments


def _in_denavit_hartenberg_frames(kinematics: Kinematics) -> tuple[list[Array], list[Array]]:
    """Centres of mass (3) and inertia tensors (3, 3) of the links in their own frames 1, 2, 3."""
    parameters = kinematics.parameters
    geometry = parameters.geometry
    centers = [
        np.array([geometry.first_link_center_of_mass - geometry.first_link_offset, 0.0, 0.0]),
        np.array([0.0, geometry.second_link_center_of_mass, 0.0]),
        np.array([geometry.third_link_center_of_mass - geometry.third_link_length, 0.0, 0.0]),
    ]
    home = kinematics.transforms(np.zeros(3))[1:4, :3, :3]
    inertias = [multiply(home[i].T * np.array(parameters.link_inertia[i]), home[i]) for i in range(3)]
    return centers, inertias
