"""A controller's settings: declared, checked, and sized for the robot that the controller moves."""

from collections.abc import Mapping
from dataclasses import MISSING, dataclass, fields, replace
from typing import Any, ClassVar, Self

import numpy as np

from prp_gym.errors import InvalidValueError, ShapeError, UnknownNameError
from prp_gym.robot.link import LinkParameters
from prp_gym.robot.parameters import RobotParameters


@dataclass(frozen=True)
class Vector:
    """What the components of a vector setting belong to, and their unit.

    Attributes:
        of: quantity with one component each: `joint`, `pose` (six components) or `parameter` of the model.
        unit: unit of the components.
        above_zero: whether 0 is refused too.
    """

    of: str
    unit: str
    above_zero: bool = False


@dataclass(frozen=True, eq=False, kw_only=True)
class Settings:
    """A controller's settings; subclasses declare them. A vector may be one number for all components.

    Two settings are equal only if they are the same object.

    Attributes:
        model: robot model, which may differ from the plant; None for the environment's nominal model.
        vectors: the settings that are vectors of finite numbers, none negative.
        numbers: the settings that are single finite numbers, none negative, with their unit.
        choices: the settings that take one of several words.
    """

    vectors: ClassVar[Mapping[str, Vector]] = {}
    numbers: ClassVar[Mapping[str, str]] = {}
    choices: ClassVar[Mapping[str, tuple[str, ...]]] = {}

    model: RobotParameters | LinkParameters | None = None

    def __post_init__(self) -> None:
        if self.model is not None and not isinstance(self.model, (RobotParameters, LinkParameters)):
            raise InvalidValueError("model", self.model, "a RobotParameters, a LinkParameters or None")
        for name, vector in self.vectors.items():
            self._make_vector(name, vector)
        for name, unit in self.numbers.items():
            self._make_number(name, unit)
        for name, allowed in self.choices.items():
            if getattr(self, name) not in allowed:
                raise UnknownNameError(name, getattr(self, name), allowed)

    @classmethod
    def from_mapping(cls, controller: str, values: Mapping[str, Any]) -> Self:
        """Settings by name.

        Raises:
            UnknownNameError: a name that the controller does not have; a word that a setting does not allow.
            InvalidValueError: a value that is not allowed; no value for a setting without default.
        """
        entries = fields(cls)
        names = [entry.name for entry in entries]
        for name in values:
            if name not in names:
                raise UnknownNameError(f"setting of controller {controller!r}", name, names)
        missing = [entry.name for entry in entries if entry.default is MISSING and entry.name not in values]
        if missing:
            given, needed = ", ".join(sorted(values)) or "none", ", ".join(missing)
            raise InvalidValueError(f"settings of controller {controller!r}", given, f"also {needed}")
        return cls(**values)

    def sized(self, sizes: Mapping[str, int]) -> Self:
        """The same settings with every vector at its full length.

        Args:
            sizes: number of components of a `joint`, a `pose` and a `parameter` vector.

        Raises:
            ShapeError: a vector of another length.
        """
        full: dict[str, Any] = {}
        for name, vector in self.vectors.items():
            value, size = getattr(self, name), sizes[vector.of]
            if value.shape not in ((), (1,), (size,)):
                raise ShapeError(f"setting {name!r}", value.shape, f"one number or ({size},)")
            full[name] = np.broadcast_to(value, (size,))
        return replace(self, **full)

    def _make_vector(self, name: str, declared: Vector) -> None:
        given, unit = getattr(self, name), declared.unit
        try:
            vector = np.array(given, dtype=np.float64)
        except (TypeError, ValueError):
            raise InvalidValueError(name, given, "one number or several", unit) from None
        if vector.ndim > 1 or not (np.isfinite(vector).all() and (vector >= 0.0).all()):
            raise InvalidValueError(name, given, "finite and at least 0", unit)
        if declared.above_zero and not (vector > 0.0).all():
            raise InvalidValueError(name, vector.tolist(), "above 0", unit)
        vector.flags.writeable = False
        object.__setattr__(self, name, vector)

    def _make_number(self, name: str, unit: str) -> None:
        given = getattr(self, name)
        if isinstance(given, bool) or not isinstance(given, (int, float, np.number)):
            raise InvalidValueError(name, given, "a number", unit)
        if not (np.isfinite(given) and given >= 0.0):
            raise InvalidValueError(name, given, "finite and at least 0", unit)
        object.__setattr__(self, name, float(given))
