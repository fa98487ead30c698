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

MEASURED_FIELDS = (
    Field.symmetric("joint_position", _JOINT_UNITS, "joint", POSITION_BOUND, "joint positions q"),
    Field.symmetric("joint_velocity", _JOINT_RATES, "joint", SPEED_BOUND, "joint velocities q̇"),
    Field.symmetric(
        "end_effector_pose",
        _POSE_UNITS,
        "world",
        (_REACH_BOUND,) * 3 + (POSITION_BOUND[0], POSITION_BOUND[2] + 2.0, np.pi),
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
"""What every environment observes, in the order of `Physics.measurement`."""

JOINT_REFERENCE_FIELDS = (
    Field.symmetric("desired_joint_position", _JOINT_UNITS, "joint", POSITION_BOUND, "q_d"),
    Field.symmetric("desired_joint_velocity", _JOINT_RATES, "joint", SPEED_BOUND, "q̇_d"),
    Field.symmetric(
        "desired_joint_acceleration", _JOINT_ACCELERATIONS, "joint", _JOINT_ACCELERATION_BOUND, "q̈_d"
    ),
)
"""The reference of joint-space tasks."""
