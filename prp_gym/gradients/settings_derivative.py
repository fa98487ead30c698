"""Derivatives of a score by a controller's settings, from those by the numbers that it keeps."""

from dataclasses import replace
from typing import Any

import numpy as np

from prp_gym.errors import PRPError
from prp_gym.gradients.differentiated_episodes import DifferentiatedEpisodes
from prp_gym.robot.arrays import Array

_STEP = 1e-4  # relative: the error of the differences below is of the order of its square, and 1e-16 over it
_LEAST = 1e-6  # step from a setting that is 0, in its unit


def by_settings(episodes: DifferentiatedEpisodes, controller: Any) -> dict[str, Array]:
    """Derivatives of the mean score by each of a controller's settings that are numbers.

    A controller computes what it keeps from its settings once, when it is made. These formulas are smooth and
    have no noise, so that differences give their derivatives to about eight digits; where a setting is 0 or
    at a limit they are one-sided.

    Args:
        episodes: episodes of the controller.
        controller: controller with `interface` and `settings`.

    Returns:
        by the name of each setting, of its shape. A setting that can be moved in neither direction, such as
        one that switches a part of the controller off, is left out.
    """
    settings, found = controller.settings, dict[str, Array]()
    for name in (*settings.vectors, *settings.numbers):
        value = np.asarray(getattr(settings, name), dtype=np.float64)
        parts = [_derivative(episodes, controller, name, index) for index in range(value.size)]
        known = [part for part in parts if part is not None]
        if known and len(known) == len(parts):
            found[name] = np.array(known).reshape(value.shape)
    return found


def _derivative(episodes: DifferentiatedEpisodes, controller: Any, name: str, index: int) -> float | None:
    """The derivative by one component of a setting; None where there is none."""
    value = np.array(getattr(controller.settings, name), dtype=np.float64)
    number = float(value.flat[index])
    step = _STEP * number or _LEAST
    here = _with(controller, name, value)

    def change(shift: float) -> float | None:
        other = value.copy()
        other.flat[index] = number + shift
        try:
            found = episodes.differences(_with(controller, name, other), here)
        except PRPError:
            return None
        return None if found is None else float(found.mean())

    above, below = change(step), change(-step)
    if above is not None and below is not None:
        return (above - below) / (2.0 * step)
    for once, direction in ((above, 1.0), (below, -1.0)):
        twice = change(2.0 * direction * step)
        if once is not None and twice is not None:
            return direction * (4.0 * once - twice) / (2.0 * step)
    return None


def _with(controller: Any, name: str, value: Array) -> Any:
    """The same controller with another value of one setting."""
    given = value if value.ndim else float(value)
    return type(controller)(controller.interface, replace(controller.settings, **{name: given}))
