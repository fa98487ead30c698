"""Errors, settling and steady state of a recorded motion or force relative to its reference.

Time runs along the second-to-last axis of vectors (..., T, d) and along the last of what is one number
per sample (..., T); every function broadcasts over the dimensions before it.
"""

import numpy as np
from numpy.typing import NDArray

from prp_gym.robot.arrays import Array

SETTLING_BAND = 0.02
"""Share of the step within which a response counts as settled."""

_FINAL_PART = 0.1


def root_mean_square(values: Array) -> Array:
    """√(mean over time of the squares): (..., T, d) -> (..., d), same units."""
    mean: Array = np.sqrt(np.mean(values**2, axis=-2))
    return mean


def root_mean_square_error(actual: Array, desired: Array) -> Array:
    """√(mean over time of the squared error).

    Args:
        actual: (..., T, d).
        desired: (..., T, d), same units.

    Returns:
        (..., d), same units.
    """
    return root_mean_square(desired - actual)


def mean_absolute_error(actual: Array, desired: Array) -> Array:
    """Mean over time of the error's absolute value; arguments as in `root_mean_square_error`.

    Times the duration it is the integral of the absolute error, IAE.
    """
    mean: Array = np.abs(desired - actual).mean(axis=-2)
    return mean


def maximum_error(actual: Array, desired: Array) -> Array:
    """Largest absolute error over time; arguments as in `root_mean_square_error`."""
    error: Array = np.abs(desired - actual).max(axis=-2)
    return error


def distance(actual: Array, desired: Array) -> Array:
    """Norm of the error at each sample: (..., T, d) twice -> (..., T), same units."""
    norm: Array = np.sqrt(((desired - actual) ** 2).sum(axis=-1))
    return norm


def root_mean_square_distance(actual: Array, desired: Array) -> Array:
    """√(mean over time of the error's squared norm): (..., T, d) twice -> (...), same units."""
    mean: Array = np.sqrt(np.mean(distance(actual, desired) ** 2, axis=-1))
    return mean


def mean_distance(actual: Array, desired: Array) -> Array:
    """Mean over time of the norm of the error: (..., T, d) twice -> (...), same units."""
    mean: Array = distance(actual, desired).mean(axis=-1)
    return mean


def maximum_distance(actual: Array, desired: Array) -> Array:
    """Largest norm of the error over time: (..., T, d) twice -> (...), same units."""
    largest: Array = distance(actual, desired).max(axis=-1)
    return largest


def is_constant(desired: Array) -> NDArray[np.bool_]:
    """(...), whether a reference (..., T, d) never moves."""
    still: NDArray[np.bool_] = np.logical_and.reduce(desired == desired[..., :1, :], axis=(-2, -1))
    return still


def time_inside_for_good(time: Array, outside: NDArray[np.bool_]) -> Array:
    """The first sample after which a response never leaves its band again.

    Args:
        time: (T) [s].
        outside: (..., T), whether each sample is outside the band.

    Returns:
        (...) [s]; infinite where the last sample is outside.
    """
    count = outside.shape[-1]
    last_outside = count - 1 - np.argmax(outside[..., ::-1], axis=-1)
    reached = np.where(outside.any(axis=-1), last_outside + 1, 0)
    settled: Array = np.append(time, np.inf)[reached]
    return settled


def steady_state_error(actual: Array, desired: Array) -> Array:
    """Mean error over the last tenth of the episode.

    Args:
        actual: (..., T, d).
        desired: (..., T, d).

    Returns:
        (..., d), signed (desired - actual); NaN if the reference moves in that part.
    """
    final = max(1, round(_FINAL_PART * actual.shape[-2]))
    error = np.mean(desired[..., -final:, :] - actual[..., -final:, :], axis=-2)
    still = is_constant(desired[..., -final:, :])
    return np.where(still[..., None], error, np.nan)
