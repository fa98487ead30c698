"""The elastic surface of a contact task: its keywords and reset options."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields

import numpy as np

from prp_gym.checks import each_within, shaped, within
from prp_gym.envs.config import describe
from prp_gym.physics.surface import Surface
from prp_gym.robot.arrays import Array
from prp_gym.tasks.parts import ResetOption

SURFACE_OPTIONS = {
    "surface_stiffness": ResetOption((), "N/m", "stiffness K of the surface"),
    "surface_damping": ResetOption((), "N·s/m", "damping D of the surface"),
    "surface_normal": ResetOption(
        (3,), "", "normal of the surface in the world frame, towards the free side"
    ),
    "surface_offset": ResetOption(
        (), "m", "offset of the surface along its unit normal n: n · p for its points p"
    ),
}

_DRAWN = "drawn at every reset"
_AT_CONTACT = "that at the drawn contact point"

SURFACE_BOUNDS = {
    "surface_stiffness": (1e-3, 1e5),
    "surface_damping": (0.0, 1e3),
    "surface_offset": (-5.0, 5.0),
}
"""Allowed values of a surface, for which observed forces stay within their declared bounds."""


def _surface(name: str, default: str) -> dict[str, str]:
    option = SURFACE_OPTIONS[name]
    return describe(option.unit, f"{option.description}; {default} if None")


_ANY_SURFACE = {
    "surface_stiffness": np.ones(1),
    "surface_damping": np.zeros(1),
    "surface_normal": np.array([[0.0, 0.0, 1.0]]),
    "surface_offset": np.zeros(1),
}


@dataclass(frozen=True)
class SurfaceOptions:
    """The surface of every episode; a value of None is drawn, or follows from the drawn contact point.

    Raises:
        InvalidValueError: a value that is not a number or outside `SURFACE_BOUNDS`, a zero normal.
        ShapeError: a normal without three components.
    """

    surface_stiffness: float | None = field(default=None, metadata=_surface("surface_stiffness", _DRAWN))
    surface_damping: float | None = field(default=None, metadata=_surface("surface_damping", _DRAWN))
    surface_normal: tuple[float, float, float] | None = field(
        default=None, metadata=_surface("surface_normal", _AT_CONTACT)
    )
    surface_offset: float | None = field(default=None, metadata=_surface("surface_offset", _AT_CONTACT))

    def __post_init__(self) -> None:
        for name, value in self.given().items():
            plain = tuple(value.tolist()) if value.ndim else float(value)
            object.__setattr__(self, name, plain)
        make_surface(_ANY_SURFACE, self.given())

    def given(self) -> dict[str, Array]:
        """The values that are not None, by name."""
        names = [entry.name for entry in fields(SurfaceOptions)]
        values = {name: getattr(self, name) for name in names}
        return {n: surface_value(n, value) for n, value in values.items() if value is not None}


def surface_value(name: str, value: object) -> Array:
    """Validate one value of the surface, given as a keyword.

    Raises:
        InvalidValueError: a value that is not numeric, or is outside `SURFACE_BOUNDS`.
        ShapeError: a value of another shape than the declared one.
    """
    option = SURFACE_OPTIONS[name]
    if name in SURFACE_BOUNDS:
        return np.array(within(name, value, SURFACE_BOUNDS[name], option.unit))
    return shaped(name, value, option.shape, option.unit)


def surface_values(name: str, values: Array) -> Array:
    """Validate one value (n, ...) of n surfaces, given as a reset option.

    Raises:
        InvalidValueError: a value outside `SURFACE_BOUNDS`.
    """
    if name in SURFACE_BOUNDS:
        return each_within(name, values, SURFACE_BOUNDS[name], SURFACE_OPTIONS[name].unit)
    return values


def make_surface(drawn: Mapping[str, Array], given: Mapping[str, Array]) -> Surface:
    """Make n surfaces from values by name.

    Args:
        drawn: Values (n, ...) of every option.
        given: Values that replace them, one for all surfaces or one (n, ...) for each.
    """
    values = {
        name: np.broadcast_to(given[name], value.shape) if name in given else value
        for name, value in drawn.items()
    }
    return Surface(**{name.removeprefix("surface_"): value for name, value in values.items()})
