"""`BatchReadings`: the arrays of MuJoCo's batch that compiled code reads after every period."""

import ctypes
from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar, Self

from numpy.typing import NDArray

READINGS = Path(__file__).with_name("batch_readings.c").read_text(encoding="utf-8")
"""The structure in C, and the function `prp_read`."""

_ARRAYS = ("sensors", "gain", "offset", "bound")
_COUNTS = (
    "rows",
    "sensor_count",
    "measured_count",
    "joints",
    "first_stop",
    "warning_kinds",
    "warning_stride",
)


class BatchReadings(ctypes.Structure):
    """`prp_readings` of the C code, which points to arrays that stay the same while MuJoCo's batch does.

    Attributes:
        sensors: sensors (N, sensor_count).
        gain: gain (N, measured_count) of the measurement.
        offset: offset (N, measured_count) of the measurement.
        bound: bounds (N, sensor_count) of the sensors' magnitudes, of which the first 2·joints are watched.
        warnings: numbers (N, warning_kinds) of MuJoCo's warnings about bad states.
        rows: number of simulations N.
        sensor_count: number of sensors.
        measured_count: number of columns of the measurement.
        joints: number of joints.
        first_stop: column of the first joint stop's violation; negative without stops.
        warning_kinds: number of kinds of warnings.
        warning_stride: distance between the warnings of two simulations.
        no_warning: value of a counter without a warning.
    """

    _fields_: ClassVar = [
        *((name, ctypes.c_void_p) for name in (*_ARRAYS, "warnings")),
        *((name, ctypes.c_long) for name in _COUNTS),
        ("no_warning", ctypes.c_int),
    ]

    @classmethod
    def of(cls, arrays: Mapping[str, NDArray[Any]], **numbers: int) -> Self:
        """Make the structure for arrays by name, which it keeps.

        Args:
            arrays: Arrays `sensors`, `gain`, `offset` and `bound`, contiguous, and `warnings`.
            numbers: The attributes `joints`, `first_stop` and `no_warning`.
        """
        warnings = arrays["warnings"]
        made = cls(**numbers)
        made.arrays = dict(arrays)
        for name, values in arrays.items():
            setattr(made, name, values.ctypes.data)
        made.rows, made.sensor_count = arrays["sensors"].shape
        made.measured_count = arrays["gain"].shape[1]
        made.warning_kinds = warnings.shape[1]
        made.warning_stride = warnings.strides[0] // warnings.itemsize
        return made
