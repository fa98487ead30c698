"""The target impedance of a contact task: its keywords."""

from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np

from prp_gym.checks import bounded
from prp_gym.envs.base.surface_options import SurfaceOptions
from prp_gym.envs.config import describe
from prp_gym.errors import ShapeError

Axes = float | tuple[float, ...] | None

_TARGET_BOUNDS = {
    "target_inertia": (1e-3, 1e3),
    "target_damping": (0.0, 1e5),
    "target_stiffness": (0.0, 1e6),
}


def _target(what: str, unit: str) -> dict[str, str]:
    text = f"{what} of the target model: one number, six (x, y, z, α, β, γ), or None for the task's default"
    return describe(unit, text)


_STIFFNESS = _target("stiffness K_P", "N/m, N·m/rad")


@dataclass(frozen=True)
class StiffnessOptions(SurfaceOptions):
    """Keywords of the surface and of the target's stiffness.

    Raises:
        InvalidValueError: a value that is not a number, is negative or is unreasonably large.
        ShapeError: a target keyword with neither one number nor six.
    """

    target_stiffness: Axes = field(default=None, metadata=_STIFFNESS)

    def __post_init__(self) -> None:
        super().__post_init__()
        _make_six(self)


@dataclass(frozen=True)
class TargetOptions(SurfaceOptions):
    """Keywords of the surface and of the target's inertia, damping and stiffness.

    Raises:
        InvalidValueError: a value that is not a number, is negative or is unreasonably large.
        ShapeError: a target keyword with neither one number nor six.
    """

    target_stiffness: Axes = field(default=None, metadata=_STIFFNESS)
    target_inertia: Axes = field(default=None, metadata=_target("inertia M_d", "kg, kg·m²"))
    target_damping: Axes = field(default=None, metadata=_target("damping K_D", "N·s/m, N·m·s/rad"))

    def __post_init__(self) -> None:
        super().__post_init__()
        _make_six(self)


def _make_six(options: Any) -> None:
    """Expand the target's keywords to one number for each axis, in place."""
    for entry in fields(options):
        value = getattr(options, entry.name)
        if entry.name in _TARGET_BOUNDS and value is not None:
            object.__setattr__(options, entry.name, _six(entry.name, value, entry.metadata["unit"]))


def _six(name: str, value: object, unit: str) -> tuple[float, ...]:
    axes = bounded(name, value, _TARGET_BOUNDS[name], unit)
    if axes.shape not in ((), (6,)):
        raise ShapeError(name, axes.shape, "one number or (6,)")
    return tuple(np.broadcast_to(axes, 6).tolist())
