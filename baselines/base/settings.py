"""A controller's settings: declared, checked, and sized for the robot that the controller moves."""

from collections.abc import Mapping
from dataclasses import MISSING, dataclass, fields, replace
from typing import Any, ClassVar, Self

import numpy as np

from prp_gym.checks import as_numbers, choice, shaped
from prp_gym.errors import InvalidValueError, ShapeError
from prp_gym.robot.link import LinkParameters
from prp_gym.robot.parameters import RobotParameters

LARGEST_SETTING = 1e9
"""Largest number of a setting, in its unit: products of settings and observations do not overflow."""

LEAST_SETTING = 1e-9
"""Least number of a setting that must be above 0, in its unit."""


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
            choice(name, getattr(self, name), allowed)

    @classmethod
    def units(cls) -> dict[str, str]:
        """Units of all settings that are numbers or vectors, by name."""
        return {name: vector.unit for name, vector in cls.vectors.items()} | dict(cls.numbers)

    @classmethod
    def from_mapping(cls, controller: str, values: Mapping[str, Any]) -> Self:
        """Settings by name.

        Raises:
            UnknownNameError: a name that the controller does not have; a word that a setting does not allow.
            ShapeError: several numbers in place of one.
            InvalidValueError: a value that is not allowed; no value for a setting without default.
        """
        entries = fields(cls)
        names = [entry.name for entry in entries]
        for name in values:
            choice(f"setting of controller {controller!r}", name, names)
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
        vector = as_numbers(name, given, unit)
        if vector.ndim > 1 or not ((vector >= 0.0) & (vector <= LARGEST_SETTING)).all():
            allowed = f"finite and at least 0, up to {LARGEST_SETTING:g}"
            raise InvalidValueError(name, given, allowed, unit)
        if declared.above_zero and not (vector >= LEAST_SETTING).all():
            raise InvalidValueError(name, vector.tolist(), f"above 0, at least {LEAST_SETTING:g}", unit)
        vector.flags.writeable = False
        object.__setattr__(self, name, vector)

    def _make_number(self, name: str, unit: str) -> None:
        given = getattr(self, name)
        number = float(shaped(name, given, (), unit))
        if not 0.0 <= number <= LARGEST_SETTING:
            raise InvalidValueError(name, given, f"finite and at least 0, up to {LARGEST_SETTING:g}", unit)
        object.__setattr__(self, name, number)
