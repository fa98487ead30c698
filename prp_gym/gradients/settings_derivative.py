"""Derivatives of a score by a controller's settings, from those by the numbers that it keeps."""

from dataclasses import replace
from typing import Any

import numpy as np

from prp_gym.gradients.differentiated_episodes import DifferentiatedEpisodes
from prp_gym.robot.arrays import Array

_STEP = 1e-4  # relative to a setting
_LEAST = 1e-6  # step from a setting that is 0, in its unit


def by_settings(episodes: DifferentiatedEpisodes, controller: Any) -> dict[str, Array]:
    """Derivatives of the mean score by each of a controller's settings that are numbers.

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

    def make(distance: float) -> Any:
        other = value.copy()
        other.flat[index] = number + distance
        return _with(controller, name, other)

    found = episodes.derivatives(make, _STEP * number or _LEAST)
    return None if found is None else float(found.mean())


def _with(controller: Any, name: str, value: Array) -> Any:
    """The same controller with another value of one setting."""
    given = value if value.ndim else float(value)
    return type(controller)(controller.interface, replace(controller.settings, **{name: given}))
