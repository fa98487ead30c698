"""Errors, settling and steady state of a recorded motion or force relative to its reference.

Time runs along the second-to-last axis of vectors (..., T, d) and along the last of what is one number
per sample (..., T); every function broadcasts over the dimensions before it.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from prp_gym.robot.arrays import Array, norm
from prp_gym.robot.shared import shared

SETTLING_BAND = 0.02
"""Share of the step within which a response counts as settled."""

_FINAL_PART = 0.1
_LEAST_SWINGS = 6  # half periods, three full oscillations in half an episode
_SUSTAINED = 0.5  # least ratio of the last amplitude to the one before


def root_mean_square(values: Array) -> Array:
    """√(mean over time of the squares): (..., T, d) -> (..., d), same units."""
    mean: Array = np.sqrt(np.mean(values**2, axis=-2))
    return mean


@shared
def absolute_error(actual: Array, desired: Array) -> Array:
    """Absolute value of the error at each sample: (..., T, d) twice -> (..., T, d), same units."""
    return np.abs(desired - actual)


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
    mean: Array = absolute_error(actual, desired).mean(axis=-2)
    return mean


def maximum_error(actual: Array, desired: Array) -> Array:
    """Largest absolute error over time; arguments as in `root_mean_square_error`."""
    largest: Array = absolute_error(actual, desired).max(axis=-2)
    return largest


@shared
def distance(actual: Array, desired: Array) -> Array:
    """Norm of the error at each sample: (..., T, d) twice -> (..., T), same units."""
    return norm(desired - actual)


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


@shared
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


def time_settled(time: Array, deviations: Sequence[Array], reversals: Sequence[int] = ()) -> float:
    """When all deviations come within their tolerances for good.

    Args:
        time: (T) [s].
        deviations: groups of components (T, any size) in units of their tolerances [1]; within them where
            the norm of a group is at most 1.
        reversals: samples, in their order, at which the reference turns back.

    Returns:
        the time [s]; infinite if the last tenth is not within the tolerances from its beginning, nor the last
        tenth before every reversal, counted from the reversal before it, and where a deviation is undefined
        (NaN).
    """
    outside = np.zeros(len(time), dtype=np.bool_)
    for group in deviations:
        outside |= ~(norm(group) <= 1.0)
    for start, end in zip((0, *reversals), reversals, strict=False):
        if outside[end - round(_FINAL_PART * (end - start)) : end + 1].any():
            return np.inf
    settled = float(time_inside_for_good(time, outside))
    return settled if settled <= time[-1 - round(_FINAL_PART * (len(time) - 1))] else np.inf


def oscillates_for_good(deviations: Sequence[Array], reference: Array) -> bool:
    """Whether a deviation keeps oscillating to the end of an episode, beyond its tolerance.

    A component does so if in the second half of the episode

    - it swings by more than its tolerance to each side of its middle in the last quarter,
    - those swings are at least half as large as in the quarter before, so that it does not decay,
    - it makes at least three full oscillations, by swings of half that amplitude, and at least twice as many
      as any component of the reference, whose motion a tracking error may repeat.

    Args:
        deviations: groups of components (T, any size) in units of their tolerances [1].
        reference: planned reference (T, size), in any units.
    """
    first = len(reference) // 2
    every = np.concatenate([group[first:] for group in deviations], axis=-1)
    if len(every) < _LEAST_SWINGS:
        return False
    before, after = (_amplitude(part) for part in np.array_split(every, 2))
    sustained = (after > 1.0) & (after >= _SUSTAINED * before)
    if not sustained.any():
        return False
    least = max(_LEAST_SWINGS, 2 * max((_swings(values) for values in reference[first:].T), default=0))
    return any(_swings(values) >= least for values in every.T[sustained])


def _amplitude(values: Array) -> Array:
    """Half of the range over time: (T, size) -> (size)."""
    half: Array = (values.max(axis=0) - values.min(axis=0)) / 2
    return half


def _swings(values: Array) -> int:
    """How often a signal (T) goes from beyond half its amplitude on one side of its middle to the other."""
    high, low = float(values.max()), float(values.min())
    away = values - (high + low) / 2
    side = np.sign(away)[np.abs(away) > (high - low) / 4]
    return int(np.count_nonzero(np.diff(side)))
