"""The classical Runge-Kutta method, for closed loops that are not environments."""

from collections.abc import Callable

import numpy as np

from tests.support.pinocchio_model import Array


def runge_kutta(slope: Callable[[float, Array], Array], state: Array, step: float, count: int) -> Array:
    """`count` steps of fourth order from time 0.

    Args:
        slope: time derivative at a time [s] and a state.
        state: state at time 0, of any shape.
        step: integration step [s].
        count: number of steps.

    Returns:
        (count + 1, ...): the states, the first included.
    """
    states = [state]
    for index in range(count):
        time = index * step
        k_1 = slope(time, state)
        k_2 = slope(time + step / 2, state + step / 2 * k_1)
        k_3 = slope(time + step / 2, state + step / 2 * k_2)
        k_4 = slope(time + step, state + step * k_3)
        state = state + step / 6 * (k_1 + 2 * k_2 + 2 * k_3 + k_4)
        states.append(state)
    return np.array(states)
