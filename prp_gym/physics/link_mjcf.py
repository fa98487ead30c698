"""The MuJoCo model of the one-joint link, generated from `LinkParameters`."""

from typing import NamedTuple

import numpy as np

from prp_gym.physics.scene import FLOOR_HEIGHT, geom, inertial, motors, numbers, opening
from prp_gym.robot.arrays import Array
from prp_gym.robot.link import NOMINAL_LINK, LinkParameters

HINGE_HEIGHT = 0.35
"""Height of the joint's axis, which is horizontal, in the plane x = 0 [m]."""

LINK_LENGTH = 0.30
"""Distance from the joint's axis to the drawn tip [m]."""

JOINT = "joint_1"
_GRAVITY = 9.81  # [m/s^2]
_LEAST_MASS = 1.0  # [kg]
_POST = 0.06  # distance from the plane in which the link swings, y = 0, to the post [m]


class PointMass(NamedTuple):
    """Mass distribution of a link with given I and G about the joint's axis.

    Attributes:
        mass: Mass (...) [kg].
        center: Centre of mass (..., 3) in the body's frame [m].
        moment: Moment of inertia (...) about the centre of mass, equal about every axis [kg m^2].
    """

    mass: Array
    center: Array
    moment: Array


def mass_distribution(inertia: Array, gravity_moment: Array) -> PointMass:
    """A body whose inertia about the joint's axis is I and whose gravity moment is G sin q.

    Many bodies have the same I and G. The mass of this one is large enough that a point mass at its centre
    of mass has less than half of I. Its frame lies on the axis at the post, so that its centre of mass is
    never the frame's origin: MuJoCo would compile a body that is balanced about its origin (G = 0) into one
    that no later value could unbalance.

    Args:
        inertia: I (...) [kg m^2].
        gravity_moment: G (...) [N m].

    Returns:
        m, l and I - m l² with G = m g l and m l² < I/2.
    """
    mass = _LEAST_MASS + 2.0 * gravity_moment**2 / (_GRAVITY**2 * inertia)
    distance = gravity_moment / (mass * _GRAVITY)
    center = np.stack([np.zeros_like(distance), np.full_like(distance, -_POST), -distance], axis=-1)
    return PointMass(mass, center, inertia - mass * distance**2)


def inertia_and_gravity(body: PointMass) -> tuple[Array, Array]:
    """I (...) [kg m^2] and G (...) [N m] of the body that `mass_distribution` returned."""
    distance = -body.center[..., 2]
    return body.moment + body.mass * distance**2, body.mass * _GRAVITY * distance


def link_to_mjcf(parameters: LinkParameters = NOMINAL_LINK, timestep: float = 0.001) -> str:
    """The link and its scene as an MJCF document.

    Args:
        parameters: Parameters of the link.
        timestep: Time step of the integration [s].

    Returns:
        Text of the document. Body `link_1`, joint `joint_1` and site `tip` have the same names as in the
        arm's model. At q = 0 the link hangs down, at q = π/2 it points along +x. It has a motor in [N m]
        without gear or limit, and the cameras `overview` and `top`.
    """
    joint, tip = JOINT, -LINK_LENGTH
    mass, center, moment = mass_distribution(
        np.array(parameters.inertia), np.array(parameters.gravity_moment)
    )
    x, y, z = center.tolist()
    return "\n".join(
        [
            '<mujoco model="link">',
            opening(timestep, _GRAVITY),
            geom("box", "0.05 0.05 0.01", "base", f'pos="0 {_POST!r} {FLOOR_HEIGHT + 0.01!r}"'),
            geom(
                "cylinder",
                "0.025",
                "base",
                f'fromto="0 {_POST!r} {FLOOR_HEIGHT!r} 0 {_POST!r} {HINGE_HEIGHT + 0.03!r}"',
            ),
            f'<body name="link_1" pos="{numbers(0.0, _POST, HINGE_HEIGHT)}">',
            inertial(float(mass), (x, y, z), (float(moment), float(moment), float(moment))),
            f'<joint name="{joint}" type="hinge" axis="0 -1 0" damping="{parameters.viscous_friction!r}"/>',
            geom("cylinder", "0.026", "base", f'fromto="0 0 0 0 {-_POST - 0.03!r} 0"', "hub"),
            geom("cylinder", "0.02", "third", f'fromto="0 {-_POST!r} 0 0 {-_POST!r} {tip!r}"', "link_1"),
            geom("sphere", "0.02", "tip", f'pos="0 {-_POST!r} {tip!r}"', "tip"),
            f'<site name="tip" pos="0 {-_POST!r} {tip!r}" size="0.005" group="4"/>',
            "</body>",
            "</worldbody>",
            motors((joint,)),
            f'<sensor><jointpos joint="{joint}"/><jointvel joint="{joint}"/>'
            '<framepos objtype="site" objname="tip"/></sensor>',
            "</mujoco>",
        ]
    )
