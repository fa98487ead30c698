"""How a controller's numbers follow from its settings."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from prp_gym.errors import PRPError
from prp_gym.evaluation.compiled_controller import CONSTANTS
from prp_gym.robot.arrays import Array
from prp_gym.symbolic.lifting import structure_of

_STEP = 1e-4  # relative: the error of the differences below is of the order of its square, and 1e-16 over it
_LEAST = 1e-6  # step from a setting that is 0, in its unit

Read = Callable[[Any], Array]


def by_settings(controller: Any, read: Read) -> dict[str, Array]:
    """Derivatives of what is read from a controller by each of its settings that are numbers.

    A controller computes what it keeps from its settings once, when it is made. These formulas are smooth and
    have no noise, so that differences give their derivatives to about eight digits; where a setting is 0 or
    at a limit they are one-sided.

    Args:
        controller: controller with `interface` and `settings`.
        read: reads numbers (K) from a controller with other settings.

    Returns:
        by the name of each setting, (components, K), where a single number has one component. A setting
        that can be moved in neither direction, such as one that switches a part of the controller off, is
        left out.
    """
    settings = controller.settings
    found = {}
    for name in (*settings.vectors, *settings.numbers):
        parts = [_derivative(controller, read, name, k) for k in range(np.size(getattr(settings, name)))]
        known = [part for part in parts if part is not None]
        if known and len(known) == len(parts):
            found[name] = np.stack(known)
    return found


def _derivative(controller: Any, read: Read, name: str, index: int) -> Array | None:
    """The derivative by one component of a setting; None where there is none."""
    value = np.array(getattr(controller.settings, name), dtype=np.float64)
    number = float(value.flat[index])
    step = _STEP * number or _LEAST
    structure = structure_of(_with(controller, name, value), CONSTANTS)

    def moved(shift: float) -> Array | None:
        other = value.copy()
        other.flat[index] = number + shift
        try:
            made = _with(controller, name, other)
        except PRPError:
            return None
        return read(made) if structure_of(made, CONSTANTS) == structure else None

    here, above, below = read(controller), moved(step), moved(-step)
    if above is not None and below is not None:
        return _difference(above, below) / (2.0 * step)
    for once, direction in ((above, 1.0), (below, -1.0)):
        twice = moved(2.0 * direction * step)
        if once is not None and twice is not None:
            parts = 4.0 * _difference(once, here) - _difference(twice, here)
            return direction * parts / (2.0 * step)
    return None


def _difference(more: Array, less: Array) -> Array:
    """The difference of numbers, of which some may be infinite in both."""
    equal = more == less
    return np.where(equal, 0.0, np.where(equal, 0.0, more) - np.where(equal, 0.0, less))


def _with(controller: Any, name: str, value: Array) -> Any:
    """The same controller with another value of one setting."""
    given = value if value.ndim else float(value)
    return type(controller)(controller.interface, replace(controller.settings, **{name: given}))
