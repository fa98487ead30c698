"""The MuJoCo model of the arm, generated from `RobotParameters`."""

import math
from dataclasses import dataclass

import mujoco

from prp_gym.errors import InvalidValueError
from prp_gym.physics.scene import (
    FLOOR_HEIGHT,
    SURFACE_GROUP,
    check_timestep,
    compile_mjcf,
    geom,
    inertial,
    motors,
    numbers,
    opening,
)
from prp_gym.physics.surface import IMPEDANCE, IMPEDANCE_RATIO
from prp_gym.robot.parameters import NOMINAL, RobotParameters

TIP_RADIUS = 0.02
"""Radius of the sphere at the tip [m]; planes are offset by it, so that depth refers to its centre."""

JOINTS = ("joint_1", "joint_2", "joint_3")


@dataclass(frozen=True)
class PhysicsSettings:
    """Settings of the simulated world.

    Attributes:
        timestep: Time step of the integration [s].
        joint_stops: Whether the joints stop at their limits.
        surface: Whether there is an elastic surface.
        surface_friction: Coulomb friction coefficient between tip and surface; 0 is frictionless.
    """

    timestep: float = 0.001
    joint_stops: bool = True
    surface: bool = False
    surface_friction: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "timestep", check_timestep(self.timestep))
        if not (self.surface_friction >= 0.0 and math.isfinite(self.surface_friction)):
            raise InvalidValueError("surface_friction", self.surface_friction, "at least 0 and finite")
        object.__setattr__(self, "surface_friction", float(self.surface_friction))


def to_mjcf(parameters: RobotParameters = NOMINAL, settings: PhysicsSettings | None = None) -> str:
    """The arm and its scene as an MJCF document.

    Args:
        parameters: Parameters of the arm.
        settings: Settings of the world; by default those of `PhysicsSettings`.

    Returns:
        Text of the document. It has the bodies `link_1` to `link_3`, joints `joint_1` to `joint_3`, site
        `tip`, motors in [N m, N, N m] without gear or limit, cameras `overview` and `top`.
    """
    world = PhysicsSettings() if settings is None else settings
    ratio = IMPEDANCE_RATIO if world.surface_friction > 0.0 else 1.0
    return "\n".join(
        [
            '<mujoco model="prp">',
            opening(world.timestep, parameters.gravity, world.surface, ratio),
            _arm(parameters, world),
            _surface_body() if world.surface else "",
            "</worldbody>",
            _surface_contact(world) if world.surface else "",
            motors(JOINTS),
            _sensors(world),
            "</mujoco>",
        ]
    )


def compile_model(parameters: RobotParameters, settings: PhysicsSettings) -> mujoco.MjModel:
    """The compiled model of `to_mjcf`, as a copy that the caller may change."""
    return compile_mjcf(to_mjcf(parameters, settings))


def _joint(parameters: RobotParameters, index: int, kind: str, axis: str, limited: bool) -> str:
    bounds = numbers(parameters.joint_lower[index], parameters.joint_upper[index])
    return (
        f'<joint name="{JOINTS[index]}" type="{kind}" axis="{axis}" range="{bounds}"'
        f' limited="{str(limited).lower()}" solreflimit="0.004 1" solimplimit="0.95 0.99 0.001"'
        f' damping="{parameters.viscous_friction[index]!r}"'
        f' frictionloss="{parameters.coulomb_friction[index]!r}"/>'
    )


def _arm(parameters: RobotParameters, world: PhysicsSettings) -> str:
    g = parameters.geometry
    (m_1, m_2, m_3), (i_1, i_2, i_3) = parameters.link_mass, parameters.link_inertia
    start = g.first_link_center_of_mass - g.first_link_cylinder_length / 2
    end = start + g.first_link_cylinder_length
    box = numbers(g.second_link_width / 2, g.second_link_length / 2, g.second_link_height / 2)
    tip_y = -g.third_link_length
    shaft = tip_y + g.third_link_cylinder_length
    limited = world.joint_stops
    return "\n".join(
        [
            geom("cylinder", numbers(0.045, 0.01), "base", f'pos="0 0 {FLOOR_HEIGHT + 0.01!r}"'),
            geom("cylinder", "0.025", "base", f'fromto="0 0 {FLOOR_HEIGHT!r} 0 0 {g.base_height - 0.03!r}"'),
            f'<body name="link_1" pos="0 0 {g.base_height!r}">',
            inertial(m_1, (g.first_link_center_of_mass, 0.0, 0.0), i_1),
            _joint(parameters, 0, "hinge", "0 0 1", limited),
            geom("cylinder", "0.03", "base", 'fromto="0 0 -0.03 0 0 0.03"', "hub"),
            geom(
                "cylinder",
                f"{g.first_link_radius!r}",
                "link",
                f'fromto="{start!r} 0 0 {end!r} 0 0"',
                "link_1",
            ),
            geom("box", "0.03 0.045 0.03", "base", f'pos="{g.first_link_offset!r} 0 0"', "slide_housing"),
            f'<body name="link_2" pos="{numbers(g.first_link_offset, -g.slide_offset, 0.0)}">',
            inertial(m_2, (0.0, g.second_link_center_of_mass, 0.0), i_2),
            _joint(parameters, 1, "slide", "0 -1 0", limited),
            geom("box", box, "slide", f'pos="0 {g.second_link_length / 2!r} 0"', "slide"),
            '<body name="link_3">',
            inertial(m_3, (0.0, -g.third_link_center_of_mass, 0.0), i_3),
            _joint(parameters, 2, "hinge", "-1 0 0", limited),
            geom("cylinder", "0.026", "base", 'fromto="-0.03 0 0 0.03 0 0"', "elbow"),
            geom(
                "cylinder",
                f"{g.third_link_radius!r}",
                "third",
                f'fromto="0 {shaft!r} 0 0 {tip_y!r} 0"',
                "link_3",
            ),
            geom("sphere", f"{TIP_RADIUS!r}", "tip", f'pos="0 {tip_y!r} 0"', "tip"),
            f'<site name="tip" pos="0 {tip_y!r} 0" size="0.005" group="4"/>',
            "</body></body></body>",
        ]
    )


def _surface_body() -> str:
    plane = geom("plane", "0.22 0.22 0.01", "surface", "", "surface", SURFACE_GROUP)
    return f'<body name="surface">{plane}</body>'


def _surface_contact(world: PhysicsSettings) -> str:
    mu = world.surface_friction
    friction = f' friction="{mu!r} {mu!r} 0.005 0.0001 0.0001"' if mu > 0.0 else ""
    return (
        f'<contact><pair name="surface" geom1="tip" geom2="surface" condim="{3 if mu > 0.0 else 1}"{friction}'
        f' solimp="{IMPEDANCE!r} {IMPEDANCE!r} 0.001 0.5 2" solref="-100 0"/></contact>'
    )


def _sensors(world: PhysicsSettings) -> str:
    """Joint state, tip pose and rates in the order of the observation, then contact, then joint stops."""
    q_1, q_2, q_3 = JOINTS
    position = [f'<jointpos joint="{name}"/>' for name in (q_1, q_2, q_3)]
    velocity = [f'<jointvel joint="{name}"/>' for name in (q_1, q_2, q_3)]
    pose = [
        '<framepos objtype="site" objname="tip"/>',
        *(f'<jointpos joint="{n}"/>' for n in (q_1, q_3, q_3)),
    ]
    rates = [
        '<framelinvel objtype="site" objname="tip"/>',
        *(f'<jointvel joint="{n}"/>' for n in (q_1, q_3, q_3)),
    ]
    stops = [f'<jointlimitpos joint="{name}"/>' for name in JOINTS]
    force = ['<contact geom1="tip" geom2="surface" num="1" data="force" reduce="netforce"/>']
    parts = [*position, *velocity, *pose, *rates]
    parts += force if world.surface else []
    parts += stops if world.joint_stops else []
    return "<sensor>" + "".join(parts) + "</sensor>"
