"""Named measurements: pure functions of a recorded episode, of a signal and some of its components."""

from collections.abc import Callable, Sequence
from typing import TypeVar

import numpy as np

from prp_gym.errors import InvalidValueError
from prp_gym.evaluation import response
from prp_gym.evaluation.metrics import joint
from prp_gym.evaluation.rollout import Rollout
from prp_gym.reproduction.predictions import error_decay
from prp_gym.reproduction.signals import series
from prp_gym.robot.arrays import Array

MEASUREMENTS: dict[str, Callable[..., Array]] = {}
"""Measurements by name: functions of a rollout that return one number per component, in its unit."""

Components = Sequence[int]
MeasureT = TypeVar("MeasureT", bound=Callable[..., Array])


def _measurement(function: MeasureT) -> MeasureT:
    """Register a function under its name."""
    MEASUREMENTS[function.__name__] = function
    return function


def _between(rollout: Rollout, signal: str, components: Components, start: float, stop: float) -> Array:
    """The rows of a signal within [start, stop] [s]."""
    time, values = series(rollout, signal, components)
    half = rollout.period / 2
    rows = values[(time > start - half) & (time < stop + half)]
    if not len(rows):
        raise InvalidValueError(
            "measured interval", (start, stop), f"times from 0 to {rollout.time[-1]:g}", "s"
        )
    return rows


@_measurement
def value_at(rollout: Rollout, signal: str, time: float, components: Components = ()) -> Array:
    """The signal at the observation nearest to a time [s]."""
    row: Array = _between(rollout, signal, components, time, time)[0]
    return row


@_measurement
def values_at(rollout: Rollout, signal: str, times: Sequence[float], components: Components = ()) -> Array:
    """The signal at the observations nearest to several times [s], one time after the other."""
    return np.concatenate([value_at(rollout, signal, time, components) for time in times])


@_measurement
def final_value(rollout: Rollout, signal: str, components: Components = ()) -> Array:
    """The signal's last value."""
    row: Array = series(rollout, signal, components)[1][-1]
    return row


@_measurement
def maximum(rollout: Rollout, signal: str, until: float = np.inf, components: Components = ()) -> Array:
    """The signal's largest value up to a time [s]."""
    largest: Array = np.nanmax(_between(rollout, signal, components, 0.0, until), axis=0)
    return largest


@_measurement
def time_of_maximum(
    rollout: Rollout, signal: str, until: float = np.inf, components: Components = ()
) -> Array:
    """Time of the signal's largest value up to a time [s]."""
    when: Array = rollout.time[np.nanargmax(_between(rollout, signal, components, 0.0, until), axis=0)]
    return when


@_measurement
def minimum(rollout: Rollout, signal: str, after: float = 0.0, components: Components = ()) -> Array:
    """The signal's smallest value after a time [s]."""
    smallest: Array = np.nanmin(_between(rollout, signal, components, after, np.inf), axis=0)
    return smallest


@_measurement
def largest_magnitude(
    rollout: Rollout, signal: str, after: float = 0.0, components: Components = ()
) -> Array:
    """The signal's largest absolute value after a time [s]."""
    largest: Array = np.abs(_between(rollout, signal, components, after, np.inf)).max(axis=0)
    return largest


@_measurement
def root_mean_square(rollout: Rollout, signal: str, after: float = 0.0, components: Components = ()) -> Array:
    """√(mean of the squares) of the signal after a time [s]."""
    return response.root_mean_square(_between(rollout, signal, components, after, np.inf))


def _response(rollout: Rollout, signal: str, until: float, components: Components) -> Array:
    """1 - e/e(0) of an error signal: 0 at the start, 1 at the goal."""
    error = _between(rollout, signal, components, 0.0, until)
    if not error[0].all():
        raise InvalidValueError(f"first value of {signal!r}", error[0].tolist(), "a step: not 0")
    normalised: Array = 1.0 - error / error[0]
    return normalised


def _one_by_one(responses: Array) -> tuple[Array, Array]:
    """Responses (T, d) as d motions (d, T, 1) of one joint each, and their goal 1."""
    motions = responses.T[..., None]
    return motions, np.ones_like(motions)


@_measurement
def overshoot(rollout: Rollout, signal: str, until: float = np.inf, components: Components = ()) -> Array:
    """Largest excess of an error signal beyond zero, as a share of its first value [%]."""
    return joint.overshoot(*_one_by_one(_response(rollout, signal, until, components)))


@_measurement
def peak_time(rollout: Rollout, signal: str, until: float = np.inf, components: Components = ()) -> Array:
    """Time at which an error signal is farthest beyond zero [s]."""
    when: Array = rollout.time[_response(rollout, signal, until, components).argmax(axis=0)]
    return when


@_measurement
def settling_time(rollout: Rollout, signal: str, until: float = np.inf, components: Components = ()) -> Array:
    """Time after which an error signal stays within 2 % of its first value [s]; infinite if it never does."""
    responses = _response(rollout, signal, until, components)
    return joint.settling_time(rollout.time[: len(responses)], *_one_by_one(responses))


@_measurement
def deviation_from_second_order(
    rollout: Rollout, signal: str, proportional_gain: float, derivative_gain: float
) -> Array:
    """Root mean square of e/e(0) minus the response of ë + K_D ė + K_P e = 0, of every component [1]."""
    decay = error_decay(rollout.time, proportional_gain, derivative_gain)[:, None]
    return response.root_mean_square_error(_response(rollout, signal, np.inf, ()), 1.0 - decay)


@_measurement
def spread_of_responses(rollout: Rollout, signal: str) -> Array:
    """Largest difference at any time between the components' e/e(0) [1]."""
    spread: Array = np.ptp(_response(rollout, signal, np.inf, ()), axis=1).max(keepdims=True)
    return spread


@_measurement
def decay_rate(
    rollout: Rollout, signal: str, target: float, start: float, stop: float, components: Components = ()
) -> Array:
    """ln(|e(start)|/|e(stop)|)/(stop - start) of the signal's distance e from a target [1/s]."""
    first = np.abs(value_at(rollout, signal, start, components) - target)
    last = np.abs(value_at(rollout, signal, stop, components) - target)
    rate: Array = np.log(first / last) / (stop - start)
    return rate
