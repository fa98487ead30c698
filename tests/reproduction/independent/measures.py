"""The measurements that the files of the experiments name, on the signals of this computation."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from tests.reproduction.independent.arm import Array
from tests.reproduction.independent.free_space import PERIOD
from tests.reproduction.independent.simulation import Signals

_BAND = 0.02  # of the first value


def _row(time: float) -> int:
    return round(time / PERIOD)


def _value_at(values: Array, time: float) -> Array:
    return np.asarray(values[_row(time)])


def _values_at(values: Array, times: Sequence[float]) -> Array:
    return np.concatenate([values[_row(time)] for time in times])


def _final_value(values: Array) -> Array:
    return np.asarray(values[-1])


def _maximum(values: Array, until: float = 1e9) -> Array:
    return np.asarray(values[: _row(until) + 1].max(axis=0))


def _time_of_maximum(values: Array, until: float = 1e9) -> Array:
    return np.asarray(PERIOD * values[: _row(until) + 1].argmax(axis=0))


def _minimum(values: Array) -> Array:
    return np.asarray(values.min(axis=0))


def _largest_magnitude(values: Array, after: float = 0.0) -> Array:
    return np.asarray(np.abs(values[_row(after) :]).max(axis=0))


def _root_mean_square(values: Array) -> Array:
    return np.asarray(np.sqrt((values**2).mean(axis=0)))


def _settling_time(values: Array, until: float = 1e9) -> Array:
    outside = np.abs(values[: _row(until) + 1]) > _BAND * np.abs(values[0])
    return np.array([PERIOD * (np.flatnonzero(column)[-1] + 1) for column in outside.T])


_MEASURES: Mapping[str, Callable[..., Array]] = {
    "value_at": _value_at,
    "values_at": _values_at,
    "final_value": _final_value,
    "maximum": _maximum,
    "time_of_maximum": _time_of_maximum,
    "minimum": _minimum,
    "largest_magnitude": _largest_magnitude,
    "root_mean_square": _root_mean_square,
    "settling_time": _settling_time,
}


def measure(signals: Signals, table: Mapping[str, Any]) -> Array:
    """The numbers of a check.

    Args:
        signals: signals of the run.
        table: table `measure` of the check: name, run, signal, components and further arguments.
    """
    arguments = dict(table)
    name, _, signal = arguments.pop("name"), arguments.pop("run"), arguments.pop("signal")
    values, components = signals[signal], arguments.pop("components", None)
    if name != "torque":
        values = values[: len(signals["joint_position"])]
    if components is not None:
        values = values[:, components]
    if signal == "torque":
        values = values[:-1]  # none is applied after the end
    return _MEASURES[name](values, **arguments)
