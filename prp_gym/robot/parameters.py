"""The arm's geometry, masses, inertias and limits: the only source of all its models."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Self, cast

import numpy as np

from prp_gym.checks import components, within
from prp_gym.errors import InvalidValueError

Vector3 = tuple[float, float, float]

LENGTHS = (1e-6, 1e3)  # [m]
MASSES = (1e-15, 1e9)  # [kg]
INERTIAS = (1e-30, 1e15)  # [kg m^2]
_FRICTIONS = (0.0, 1e9)
_TORQUES = (1e-9, 1e12)
_GRAVITIES = (0.0, 1e6)  # [m/s^2]
_JOINTS = (-1e6, 1e6)
_DENSITIES = (1e-6, 1e9)  # [kg/m^3]
_FACTORS = (1e-9, 1e9)

JOINT_UNITS = ("rad", "m", "rad")
TORQUE_UNITS = ("N·m", "N", "N·m")


@dataclass(frozen=True)
class ArmGeometry:
    """Lengths of the arm [m]; the symbols are those of the Denavit-Hartenberg table.

    Attributes:
        base_height: d_0, height of joint 1's frame above the floor.
        first_link_offset: a_1, distance from joint 1's axis to the slide.
        slide_offset: d̄_2, extension of the slide at q_2 = 0.
        third_link_length: a_3, distance from joint 3's axis to the tip.
        first_link_radius: Radius r_1 of the solid cylinder.
        first_link_cylinder_length: Length h_1 of the cylinder, which spans hub to slide housing.
        first_link_center_of_mass: Distance c_1 of the centre of mass from joint 1's axis along the link.
        second_link_length: a_2, long side of the box, along the slide.
        second_link_width: b_2, horizontal side of the box across the slide.
        second_link_height: c_2, vertical side of the box.
        third_link_radius: Radius r_3 of the solid cylinder.
        third_link_cylinder_length: Length h_3 of the solid cylinder, which ends at the tip.
    """

    base_height: float = 0.15
    first_link_offset: float = 0.40
    slide_offset: float = 0.30
    third_link_length: float = 0.24
    first_link_radius: float = 0.02
    first_link_cylinder_length: float = 0.35
    first_link_center_of_mass: float = 0.20
    second_link_length: float = 0.30
    second_link_width: float = 0.03
    second_link_height: float = 0.03
    third_link_radius: float = 0.02
    third_link_cylinder_length: float = 0.24

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            object.__setattr__(self, name, within(name, value, LENGTHS, "m"))

    @property
    def second_link_center_of_mass(self) -> float:
        """Distance from link 2's outer end back to its centre of mass (a_2/2) [m]."""
        return self.second_link_length / 2

    @property
    def third_link_center_of_mass(self) -> float:
        """Distance from joint 3's axis to link 3's centre of mass [m]."""
        return self.third_link_length - self.third_link_cylinder_length / 2

    def volumes(self) -> Vector3:
        """Volume of each link's solid [m^3]."""
        return (
            math.pi * self.first_link_radius**2 * self.first_link_cylinder_length,
            self.second_link_length * self.second_link_width * self.second_link_height,
            math.pi * self.third_link_radius**2 * self.third_link_cylinder_length,
        )

    def inertias(self, masses: Vector3) -> tuple[Vector3, Vector3, Vector3]:
        """Principal moments of inertia of solids of the given masses [kg m^2].

        About each link's centre of mass, along its link frame: the frame whose axes coincide with the
        world's at q = 0, so that link 1 lies along x, links 2 and 3 along y.
        """
        first_axial, first_across = _cylinder(
            masses[0], self.first_link_radius, self.first_link_cylinder_length
        )
        third_axial, third_across = _cylinder(
            masses[2], self.third_link_radius, self.third_link_cylinder_length
        )
        a, b, c = self.second_link_length, self.second_link_width, self.second_link_height
        box = masses[1] / 12
        return (
            (first_axial, first_across, first_across),
            (box * (a**2 + c**2), box * (b**2 + c**2), box * (a**2 + b**2)),
            (third_across, third_axial, third_across),
        )


def _cylinder(mass: float, radius: float, length: float) -> tuple[float, float]:
    """Moments of inertia of a solid cylinder about its axis and across it [kg m^2]."""
    return mass * radius**2 / 2, mass * (3 * radius**2 + length**2) / 12


ALUMINIUM_DENSITY = 2710.0
_VECTORS = (
    ("link_mass", MASSES, "kg"),
    ("viscous_friction", _FRICTIONS, "N·m·s/rad, N·s/m"),
    ("coulomb_friction", _FRICTIONS, "N·m, N"),
    ("joint_lower", _JOINTS, ", ".join(JOINT_UNITS)),
    ("joint_upper", _JOINTS, ", ".join(JOINT_UNITS)),
    ("torque_limit", _TORQUES, ", ".join(TORQUE_UNITS)),
)
_GEOMETRY = ArmGeometry()
_MASS: Vector3 = (
    ALUMINIUM_DENSITY * _GEOMETRY.volumes()[0],
    ALUMINIUM_DENSITY * _GEOMETRY.volumes()[1],
    ALUMINIUM_DENSITY * _GEOMETRY.volumes()[2],
)


@dataclass(frozen=True)
class RobotParameters:
    """Everything that the closed-form model, the MuJoCo model and the URDF are generated from.

    The defaults are those of the nominal arm. Masses are not derived from another geometry; use
    `from_geometry` for that. The joint order is (1, 2, 3); joints 1 and 3 are revolute, joint 2 is prismatic.

    Attributes:
        geometry: Lengths of the arm [m].
        link_mass: Masses of the links (3) [kg].
        link_inertia: Principal moments of inertia (x, y, z) of each link about its centre of mass, in the
            link frame, whose axes coincide with the world's at q = 0 [kg m^2].
        gravity: Magnitude of the gravitational acceleration, which points along -z [m/s^2].
        viscous_friction: Coefficients F_v of the viscous friction (3) [N m s/rad, N s/m, N m s/rad].
        coulomb_friction: Coulomb friction F_s (3) [N m, N, N m].
        joint_lower: Lower joint limits (3) [rad, m, rad].
        joint_upper: Upper joint limits (3) [rad, m, rad].
        torque_limit: Actuator limits (3) [N m, N, N m].

    Raises:
        InvalidValueError: a value that is not a number or is out of bounds, inertias that no solid can have,
            or an empty joint range.
    """

    geometry: ArmGeometry = field(default_factory=ArmGeometry)
    link_mass: Vector3 = _MASS
    link_inertia: tuple[Vector3, Vector3, Vector3] = _GEOMETRY.inertias(_MASS)
    gravity: float = 9.81
    viscous_friction: Vector3 = (0.0, 0.0, 0.0)
    coulomb_friction: Vector3 = (0.0, 0.0, 0.0)
    joint_lower: Vector3 = (-math.pi, -0.3, -math.pi)
    joint_upper: Vector3 = (math.pi, 0.0, math.pi)
    torque_limit: Vector3 = (50.0, 100.0, 10.0)

    def __post_init__(self) -> None:
        if not isinstance(self.geometry, ArmGeometry):
            raise InvalidValueError("geometry", self.geometry, "an ArmGeometry")
        object.__setattr__(self, "gravity", within("gravity", self.gravity, _GRAVITIES, "m/s²"))
        for name, bounds, unit in _VECTORS:
            object.__setattr__(self, name, components(name, getattr(self, name), 3, bounds, unit))
        object.__setattr__(self, "link_inertia", _checked_inertia(self.link_inertia))
        if not all(low < high for low, high in zip(self.joint_lower, self.joint_upper, strict=True)):
            raise InvalidValueError("joint_upper", self.joint_upper, f"above joint_lower {self.joint_lower}")

    @classmethod
    def from_geometry(cls, geometry: ArmGeometry, density: float = ALUMINIUM_DENSITY) -> Self:
        """Parameters of solid links with the given lengths and density [kg/m^3].

        Raises:
            InvalidValueError: a value that is not a geometry, or a density that is out of bounds.
        """
        if not isinstance(geometry, ArmGeometry):
            raise InvalidValueError("geometry", geometry, "an ArmGeometry")
        dense = within("density", density, _DENSITIES, "kg/m³")
        first, second, third = (dense * volume for volume in geometry.volumes())
        masses = (first, second, third)
        return cls(geometry=geometry, link_mass=masses, link_inertia=geometry.inertias(masses))

    def with_masses(self, masses: Sequence[float]) -> Self:
        """The same arm with other link masses (3) [kg]; the inertias scale with the masses."""
        given = components("masses", masses, 3, MASSES, "kg")
        return self._scaled([new / old for new, old in zip(given, self.link_mass, strict=True)])

    def scaled(self, factors: Sequence[float]) -> Self:
        """Masses and inertias multiplied by a factor per link (3), as for a link of another density."""
        return self._scaled(components("mass factors", factors, 3, _FACTORS, ""))

    def _scaled(self, factors: Sequence[float]) -> Self:
        f1, f2, f3 = factors
        m1, m2, m3 = self.link_mass
        i1, i2, i3 = self.link_inertia
        return replace(
            self,
            link_mass=(m1 * f1, m2 * f2, m3 * f3),
            link_inertia=(
                (i1[0] * f1, i1[1] * f1, i1[2] * f1),
                (i2[0] * f2, i2[1] * f2, i2[2] * f2),
                (i3[0] * f3, i3[1] * f3, i3[2] * f3),
            ),
        )


def _checked_inertia(inertia: object) -> tuple[Vector3, Vector3, Vector3]:
    """Moments of inertia of three links, as plain numbers.

    Raises:
        InvalidValueError: other than three moments for each of three links, or moments that no solid has.
    """
    if not isinstance(inertia, Sequence | np.ndarray) or len(inertia) != 3:
        raise InvalidValueError("link_inertia", inertia, "three moments for each of three links", "kg·m²")
    rows = []
    for index, given in enumerate(inertia, start=1):
        moments = components(f"link_inertia of link {index}", given, 3, INERTIAS, "kg·m²")
        if 2 * max(moments) > sum(moments) * (1 + 1e-12):
            allowed = "no moment above the sum of the others"
            raise InvalidValueError(f"link_inertia of link {index}", moments, allowed, "kg·m²")
        rows.append(moments)
    return cast(tuple[Vector3, Vector3, Vector3], tuple(rows))


def _report_parameters() -> RobotParameters:
    """Parameters of the report with the erroneous inertias with which its printed matrices were computed.

    Its tensors have 1/2 instead of 1/12 across a cylinder's axis. They are shifted to the joint frame
    although they are used with the Jacobian of the centre of mass, so that m h²/4 counts twice. The moment
    used for the slide is the one about the slide's long axis.
    """
    nominal = RobotParameters()
    geometry, (m1, _, m3) = nominal.geometry, nominal.link_mass
    (axial_1, _, _), (_, slide, _), (_, axial_3, _) = nominal.link_inertia
    across_1 = m1 * (1.5 * geometry.first_link_radius**2 + 0.75 * geometry.first_link_cylinder_length**2)
    across_3 = m3 * (1.5 * geometry.third_link_radius**2 + 0.75 * geometry.third_link_cylinder_length**2)
    return replace(
        nominal,
        link_inertia=(
            (axial_1, across_1, across_1),
            (slide, slide, slide),
            (across_3, axial_3, across_3),
        ),
    )


NOMINAL = RobotParameters()
REPORT = _report_parameters()
