"""Closed forms of the expected results, by name: pure functions that are independent of any run."""

import cmath
import inspect
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from prp_gym.errors import InvalidValueError
from prp_gym.robot.arrays import Array


@dataclass(frozen=True, eq=False)
class Formula:
    """A closed form.

    Attributes:
        name: name by which data files refer to the formula.
        text: the formula in one line.
        source: source of the formula.
        compute: function that evaluates the formula.
    """

    name: str
    text: str
    source: str
    compute: Callable[..., Any]


FunctionT = TypeVar("FunctionT", bound=Callable[..., Any])

FORMULAS: dict[str, Formula] = {}
"""Formulas by name; the first line of a docstring is the formula, and the last one names its source."""


def formula(function: FunctionT) -> FunctionT:
    """Register a function under its name."""
    lines = inspect.cleandoc(function.__doc__ or "").splitlines()
    source = next(line.removeprefix("Source: ") for line in lines if line.startswith("Source: "))
    FORMULAS[function.__name__] = Formula(
        function.__name__, lines[0].rstrip("."), source.rstrip("."), function
    )
    return function


def error_decay(time: ArrayLike, proportional_gain: float, derivative_gain: float) -> Array:
    """The solution of ë + K_D ė + K_P e = 0 from e = 1 at rest, of any damping.

    e = exp(s_1 t)(1 - s_1 φ), s_1 = -K_D/2 + δ, δ² = K_D²/4 - K_P, φ = (1 - exp(-2δt))/(2δ), or t at δ = 0.

    Args:
        time: (...) [s].
        proportional_gain: K_P, above 0 [1/s^2].
        derivative_gain: K_D, above 0 [1/s].

    Returns:
        (...) error.

    Raises:
        InvalidValueError: a gain that is not above 0.
    """
    root, delta = _slowest_root(proportional_gain, derivative_gain)
    t = np.asarray(time, dtype=np.float64)
    phi = -np.expm1(-2.0 * delta * t) / (2.0 * delta) if delta else t
    return np.asarray((np.exp(root * t) * (1.0 - root * phi)).real)


def _slowest_root(proportional_gain: float, derivative_gain: float) -> tuple[complex, complex]:
    """The root -K_D/2 + δ of s² + K_D s + K_P [1/s], and δ."""
    for name, gain, unit in (
        ("proportional_gain", proportional_gain, "1/s^2"),
        ("derivative_gain", derivative_gain, "1/s"),
    ):
        if not 0.0 < gain < math.inf:
            raise InvalidValueError(name, gain, "above 0 and finite", unit)
    delta = cmath.sqrt(derivative_gain**2 / 4.0 - proportional_gain)
    return delta - derivative_gain / 2.0, delta


def _damped_frequency(proportional_gain: float, derivative_gain: float) -> float:
    """√(K_P - K_D²/4), the damped natural frequency of an underdamped response [rad/s]."""
    frequency = _slowest_root(proportional_gain, derivative_gain)[1].imag
    if not frequency:
        most = 2.0 * math.sqrt(proportional_gain)
        raise InvalidValueError("derivative_gain", derivative_gain, f"below 2√K_P = {most:g}", "1/s")
    return frequency


@formula
def error_after_step(
    step: Sequence[float], proportional_gain: float, derivative_gain: float, time: float
) -> Array:
    """Response q̃(t) of q̃¨ + K_D q̃˙ + K_P q̃ = 0, q̃(0) = step, q̃˙(0) = 0.

    Args:
        step: q̃(0) (d), any unit.
        proportional_gain: K_P [1/s^2].
        derivative_gain: K_D [1/s].
        time: t [s].

    Returns:
        (d) in the unit of the step.

    Raises:
        InvalidValueError: a gain that is not above 0.

    Source: [S] 8.5.2; [R] 7.1.
    """
    return np.array(step) * error_decay(time, proportional_gain, derivative_gain)


@formula
def second_order_overshoot(proportional_gain: float, derivative_gain: float, joints: int = 3) -> Array:
    """Overshoot: 100 exp(-πζ/√(1 - ζ²)), ζ = K_D/(2√K_P).

    Args:
        proportional_gain: K_P [1/s^2].
        derivative_gain: K_D, below 2√K_P [1/s].
        joints: number of joints that have this response.

    Returns:
        (joints) overshoot [%].

    Raises:
        InvalidValueError: a gain that is not above 0, a response that does not oscillate.

    Source: [S] 8.5.2, step response of a second-order system; [R] 7.1.
    """
    frequency = _damped_frequency(proportional_gain, derivative_gain)
    return np.full(joints, 100.0 * math.exp(-math.pi * derivative_gain / (2.0 * frequency)))


@formula
def second_order_peak_time(proportional_gain: float, derivative_gain: float, joints: int = 3) -> Array:
    """Peak time: π/√(K_P - K_D²/4).

    Args:
        proportional_gain: K_P [1/s^2].
        derivative_gain: K_D, below 2√K_P [1/s].
        joints: number of joints that have this response.

    Returns:
        (joints) time of the first peak [s].

    Raises:
        InvalidValueError: a gain that is not above 0, a response that does not oscillate.

    Source: [S] 8.5.2, step response of a second-order system; [R] 7.1.
    """
    return np.full(joints, math.pi / _damped_frequency(proportional_gain, derivative_gain))
