"""Central differences of a simulated arm by its state, beside which exact derivatives stand."""

from collections.abc import Callable

import numpy as np

from tests.support.pinocchio_model import Array

WIDTH = 3e-6
"""Width of differences, relative to 1 + |value|: far below 1e-3, in which the impedance of a stop changes."""


def differences(function: Callable[[Array], Array], at: Array) -> Array:
    """Central differences of the fourth order (results, arguments)."""
    columns = []
    for index in range(len(at)):
        width = WIDTH * max(1.0, abs(at[index]))
        values = []
        for share in (1.0, -1.0, 2.0, -2.0):
            moved = at.copy()
            moved[index] += share * width
            values.append(function(moved))
        columns.append((8.0 * (values[0] - values[1]) - (values[2] - values[3])) / (12.0 * width))
    return np.stack(columns, axis=1)
