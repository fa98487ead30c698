"""Declared observation fields: the one source of spaces, documentation tables and named access."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import ArrayLike

from prp_gym.checks import Array, as_array, check_finite, choice
from prp_gym.errors import InvalidValueError, NonFiniteError, ShapeError

LARGEST_OBSERVATION = 1e12
"""Largest magnitude that a policy accepts, in the units of the fields; all declared bounds are far below."""


POSITION_BOUND = (100.0, 2.0, 100.0)
SPEED_BOUND = (500.0, 100.0, 500.0)
"""A simulation whose joints leave these bounds [rad, m, rad] and [rad/s, m/s, rad/s] has diverged."""

_REACH_BOUND = 5.0  # [m]: 2 m of slide and the lengths of the arm, rounded up
_TIP_SPEED_BOUND = 3000.0  # [m/s]: tip speed at the joint speed bounds and that reach, rounded up
_JOINT_ACCELERATION_BOUND = (1e5, 1e4, 1e5)
_TIP_ACCELERATION_BOUND = 1e6


@dataclass(frozen=True)
class Field:
    """One named part of an observation.

    Attributes:
        name: Name by which users and controllers refer to it.
        units: Units of the components; their number is the size of the field.
        frame: Frame in which it is expressed.
        low: Lower bounds, in these units.
        high: Upper bounds, in these units.
        description: Meaning of the field.
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
        """The shape (size,) of the field."""
        return (len(self.units),)

    @classmethod
    def symmetric(
        cls, name: str, units: tuple[str, ...], frame: str, bound: Sequence[float], description: str
    ) -> Field:
        """A field whose bounds are ±bound."""
        high = tuple(float(value) for value in bound)
        return cls(name, units, frame, tuple(-value for value in high), high, description)


class ObservationLayout:
    """The positions of the fields in a flat observation.

    Args:
        fields: Fields in the order of the observation.

    Raises:
        InvalidValueError: no field, or a name that occurs twice.
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
            UnknownNameError: a field that does not exist.
        """
        return self.slices[choice("observation field", name, self.slices)]

    def split(self, observation: ArrayLike) -> dict[str, Array]:
        """Split a flat observation into named fields.

        Args:
            observation: Observations (..., size).

        Returns:
            A view (..., field size) for each field, by name.

        Raises:
            ShapeError: a last axis of another size.
            InvalidValueError: values that are not numbers.
        """
        flat = self._flat(observation)
        return {name: flat[..., part] for name, part in self.slices.items()}

    def checked(self, observation: object) -> Array:
        """Observations as policies accept them: finite numbers of the layout's size.

        Args:
            observation: Observations (..., size), as the user gives them.

        Returns:
            The same (..., size), float64.

        Raises:
            InvalidValueError: values that are not numbers, or are larger than any observation.
            ShapeError: a last axis of another size.
            NonFiniteError: NaN or infinity, with the field.
        """
        flat = self._flat(observation)
        try:
            check_finite("observation", flat, largest=LARGEST_OBSERVATION)
        except (InvalidValueError, NonFiniteError):
            for name, part in self.slices.items():
                check_finite(f"observation field {name!r}", flat[..., part], largest=LARGEST_OBSERVATION)
        return flat

    def _flat(self, observation: object) -> Array:
        flat = as_array("observation", observation)
        if flat.ndim == 0 or flat.shape[-1] != self.size:
            raise ShapeError("observation", flat.shape, f"(..., {self.size})")
        return flat

    def space(self) -> Box[np.float64]:
        """The observation space of one environment, float64."""
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
"""Observed in every environment of the arm, in the order of `Physics.measurement`."""

CONTACT_FORCE = Field.symmetric(
    "contact_force", ("N",) * 3, "world", (_LARGEST_FORCE,) * 3, "force h_e by the tip on the surface"
)
"""Measured beside `MEASURED_FIELDS` in worlds with a surface; it follows them in `Physics.measurement`."""

JOINT_REFERENCE_FIELDS = (
    Field.symmetric(
        "desired_joint_position", _JOINT_UNITS, "joint", POSITION_BOUND, "desired joint positions q_d"
    ),
    Field.symmetric(
        "desired_joint_velocity", _JOINT_RATES, "joint", SPEED_BOUND, "desired joint velocities q̇_d"
    ),
    Field.symmetric(
        "desired_joint_acceleration",
        _JOINT_ACCELERATIONS,
        "joint",
        _JOINT_ACCELERATION_BOUND,
        "desired joint accelerations q̈_d",
    ),
)
"""The reference of joint-space tasks."""

POSE_REFERENCE_FIELDS = (
    Field.symmetric(
        "desired_pose", _POSE_UNITS, "world", _POSE_BOUND, "desired pose x_d: tip position and α, β, γ"
    ),
    Field.symmetric(
        "desired_velocity",
        _POSE_RATES,
        "world",
        (_TIP_SPEED_BOUND,) * 3 + (SPEED_BOUND[0], SPEED_BOUND[2], 1.0),
        "time derivative of the desired pose, ẋ_d",
    ),
    Field.symmetric(
        "desired_acceleration",
        ("m/s²",) * 3 + ("rad/s²",) * 3,
        "world",
        (_TIP_ACCELERATION_BOUND,) * 3 + (_JOINT_ACCELERATION_BOUND[0], _JOINT_ACCELERATION_BOUND[2], 1.0),
        "second time derivative of the desired pose, ẍ_d",
    ),
)
"""The reference of operational-space tasks."""

DESIRED_FORCE = Field.symmetric(
    "desired_force",
    ("N",) * 3,
    "world",
    (_LARGEST_FORCE,) * 3,
    "desired force f_d by the tip on the surface",
)
"""The reference of force tasks beside the pose."""

MODEL_POSE = Field.symmetric(
    "model_pose", _POSE_UNITS, "world", (np.inf,) * 6, "pose of the target model under the contact force"
)
"""The reference of the errors of compliance, impedance and admittance tasks; recorded, not observed."""

FORCE_ERROR = Field.symmetric(
    "force_error",
    ("1", "1"),
    "world",
    (np.inf,) * 2,
    "relative force error, in which an excess counts more than its size; disturbance of the contact",
)
"""What the errors of force tasks keep of the contact; recorded, not observed."""

LINK_POSITION_BOUND = 1e5
"""Bound of the link's unlimited rotation [rad], which takes 200 s at its largest speed."""

LINK_FIELDS = (
    Field.symmetric("joint_position", ("rad",), "joint", (LINK_POSITION_BOUND,), "joint position q"),
    Field.symmetric("joint_velocity", ("rad/s",), "joint", SPEED_BOUND[:1], "joint velocity q̇"),
)
"""Observed in the environment of the single link, in the order of `LinkPhysics.measurement`."""

LINK_REFERENCE_FIELDS = (
    Field.symmetric(
        "desired_joint_position", ("rad",), "joint", (LINK_POSITION_BOUND,), "desired joint position q_d"
    ),
    Field.symmetric(
        "desired_joint_velocity", ("rad/s",), "joint", SPEED_BOUND[:1], "desired joint velocity q̇_d"
    ),
    Field.symmetric(
        "desired_joint_acceleration",
        ("rad/s²",),
        "joint",
        _JOINT_ACCELERATION_BOUND[:1],
        "desired joint acceleration q̈_d",
    ),
)
"""The reference of the single link."""
