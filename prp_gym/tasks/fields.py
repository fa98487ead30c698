"""Declared observation fields: the one source of spaces, documentation tables and named access."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import ArrayLike

from prp_gym.errors import InvalidValueError, ShapeError, UnknownNameError
from prp_gym.robot.arrays import Array

POSITION_BOUND = (100.0, 2.0, 100.0)
SPEED_BOUND = (500.0, 100.0, 500.0)
"""A simulation whose joints leave these bounds [rad, m, rad] and [rad/s, m/s, rad/s] has diverged."""

_REACH_BOUND = 5.0  # [m]: 2 m of slide beyond the arm's own lengths, rounded up
_TIP_SPEED_BOUND = 3000.0  # [m/s]: the speed bounds at that reach, rounded up
_JOINT_ACCELERATION_BOUND = (1e5, 1e4, 1e5)
_TIP_ACCELERATION_BOUND = 1e6


@dataclass(frozen=True)
class Field:
    """One named part of an observation.

    Attributes:
        name: as users and laws ask for it.
        units: one a component; their number is the field's size.
        frame: what it is resolved in.
        low: lower bounds, in the units.
        high: upper bounds, in the units.
        description: what it is.
    """

    name: str
    units: tuple[str, ...]
    frame: str
    low: tuple[float, ...]
    high: tuple[float, ...]
    description: str

    def __post_init__(self) -> None:
        if not len(self.units) == len(self.low) == len(self.high) > 0:
            sizes = (len(self.units), len(self.low), len(self.high))
            raise InvalidValueError(
                f"sizes of field {self.name!r}", sizes, "as many units as bounds, at least 1"
            )

    @property
    def shape(self) -> tuple[int]:
        """(size,)."""
        return (len(self.units),)

    @classmethod
    def symmetric(
        cls, name: str, units: tuple[str, ...], frame: str, bound: Sequence[float], description: str
    ) -> "Field":
        """A field whose bounds are ±bound."""
        high = tuple(float(value) for value in bound)
        return cls(name, units, frame, tuple(-value for value in high), high, description)


class ObservationLayout:
    """Where each field lies in a flat observation.

    Args:
        fields: in order.

    Raises:
        InvalidValueError: no field, or a name given twice.
    """

    def __init__(self, fields: Sequence[Field]) -> None:
        self.fields = tuple(fields)
        names = [field.name for field in self.fields]
        if not names or len(set(names)) < len(names):
            raise InvalidValueError("observation fields", names, "at least one, each name once")
        ends = np.cumsum([field.shape[0] for field in self.fields]).tolist()
        starts = [0, *ends[:-1]]
        self.slices = {
            field.name: slice(start, end) for field, start, end in zip(self.fields, starts, ends, strict=True)
        }
        self.size = int(ends[-1])

    @property
    def names(self) -> tuple[str, ...]:
        """The fields' names, in order."""
        return tuple(self.slices)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, ObservationLayout) and self.fields == other.fields

    def __hash__(self) -> int:
        return hash(self.fields)

    def index(self, name: str) -> slice:
        """The slice of a field.

        Raises:
            UnknownNameError: no such field.
        """
        try:
            return self.slices[name]
        except KeyError:
            raise UnknownNameError("observation field", name, self.slices) from None

    def split(self, observation: ArrayLike) -> dict[str, Array]:
        """A flat observation as named parts.

        Args:
            observation: (..., size).

        Returns:
            per field a view (..., field size).

        Raises:
            ShapeError: another last axis.
        """
        flat = np.asarray(observation, dtype=np.float64)
        if flat.ndim == 0 or flat.shape[-1] != self.size:
            raise ShapeError("observation", flat.shape, f"(..., {self.size})")
        return {name: flat[..., part] for name, part in self.slices.items()}

    def space(self) -> Box[np.float64]:
        """The space of one observation, float64."""
        low = np.array([value for field in self.fields for value in field.low])
        high = np.array([value for field in self.fields for value in field.high])
        return Box(low, high, dtype=np.float64)


_JOINT_UNITS = ("rad", "m", "rad")
_JOINT_RATES = ("rad/s", "m/s", "rad/s")
_JOINT_ACCELERATIONS = ("rad/s²", "m/s²", "rad/s²")
_POSE_UNITS = ("m", "m", "m", "rad", "rad", "rad")
_POSE_RATES = ("m/s", "m/s", "m/s", "rad/s", "rad/s", "rad/s")

_LARGEST_FORCE = 1e6  # [N]: a stiffness of 20 kN/m at the reach's bound, rounded up
_POSE_BOUND = (_REACH_BOUND,) * 3 + (POSITION_BOUND[0], POSITION_BOUND[2] + 2.0, np.pi)

MEASURED_FIELDS = (
    Field.symmetric("joint_position", _JOINT_UNITS, "joint", POSITION_BOUND, "joint positions q"),
    Field.symmetric("joint_velocity", _JOINT_RATES, "joint", SPEED_BOUND, "joint velocities q̇"),
    Field.symmetric(
        "end_effector_pose",
        _POSE_UNITS,
        "world",
        _POSE_BOUND,
        "tip position and ZXZ Euler angles α, β, γ (γ is always π/2)",
    ),
    Field.symmetric(
        "end_effector_velocity",
        _POSE_RATES,
        "world",
        (_TIP_SPEED_BOUND,) * 3 + (SPEED_BOUND[0], SPEED_BOUND[2], 1.0),
        "time derivative of the pose, J_A q̇ (γ̇ is always 0)",
    ),
)
"""What every environment of the arm observes, in the order of `Physics.measurement`."""

CONTACT_FORCE = Field.symmetric(
    "contact_force", ("N",) * 3, "world", (_LARGEST_FORCE,) * 3, "force h_e by the tip on the surface"
)
"""What is measured beside `MEASURED_FIELDS` where there is a surface; next in `Physics.measurement`."""

JOINT_REFERENCE_FIELDS = (
    Field.symmetric("desired_joint_position", _JOINT_UNITS, "joint", POSITION_BOUND, "q_d"),
    Field.symmetric("desired_joint_velocity", _JOINT_RATES, "joint", SPEED_BOUND, "q̇_d"),
    Field.symmetric(
        "desired_joint_acceleration", _JOINT_ACCELERATIONS, "joint", _JOINT_ACCELERATION_BOUND, "q̈_d"
    ),
)
"""The reference of joint-space tasks."""

POSE_REFERENCE_FIELDS = (
    Field.symmetric("desired_pose", _POSE_UNITS, "world", _POSE_BOUND, "x_d: tip position and α, β, γ"),
    Field.symmetric(
        "desired_velocity",
        _POSE_RATES,
        "world",
        (_TIP_SPEED_BOUND,) * 3 + (SPEED_BOUND[0], SPEED_BOUND[2], 1.0),
        "ẋ_d",
    ),
    Field.symmetric(
        "desired_acceleration",
        ("m/s²",) * 3 + ("rad/s²",) * 3,
        "world",
        (_TIP_ACCELERATION_BOUND,) * 3 + (_JOINT_ACCELERATION_BOUND[0], _JOINT_ACCELERATION_BOUND[2], 1.0),
        "ẍ_d",
    ),
)
"""The reference of operational-space tasks."""

DESIRED_FORCE = Field.symmetric(
    "desired_force", ("N",) * 3, "world", (_LARGEST_FORCE,) * 3, "f_d, by the tip on the surface"
)
"""What force tasks ask for."""

MODEL_POSE = Field.symmetric(
    "model_pose", _POSE_UNITS, "world", (np.inf,) * 6, "where the target model, driven by the force, would be"
)
"""Against what compliance, impedance and admittance tasks judge; recorded, not observed."""

LINK_POSITION_BOUND = 1e5
"""The link turns freely [rad]: at its greatest speed this takes 200 s."""

LINK_FIELDS = (
    Field.symmetric("joint_position", ("rad",), "joint", (LINK_POSITION_BOUND,), "joint position q"),
    Field.symmetric("joint_velocity", ("rad/s",), "joint", SPEED_BOUND[:1], "joint velocity q̇"),
)
"""What the environment of the single link observes, in the order of `LinkPhysics.measurement`."""

LINK_REFERENCE_FIELDS = (
    Field.symmetric("desired_joint_position", ("rad",), "joint", (LINK_POSITION_BOUND,), "q_d"),
    Field.symmetric("desired_joint_velocity", ("rad/s",), "joint", SPEED_BOUND[:1], "q̇_d"),
    Field.symmetric("desired_joint_acceleration", ("rad/s²",), "joint", _JOINT_ACCELERATION_BOUND[:1], "q̈_d"),
)
"""The reference of the single link."""
