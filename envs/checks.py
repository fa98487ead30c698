"""The one place where keywords and reset options become numbers."""

import numpy as np

from prp_gym.errors import InvalidValueError, ShapeError
from prp_gym.robot.arrays import Array


def as_numbers(what: str, value: object, unit: str = "") -> Array:
    """A value as an array of numbers; texts and truth values are none.

    Raises:
        InvalidValueError: not a number or numbers.
    """
    try:
        numbers = np.asarray(value)
    except ValueError:  # rows of different lengths
        numbers = np.asarray(None)
    if numbers.dtype.kind not in "iuf":
        raise InvalidValueError(what, value, "a number or numbers", unit)
    return numbers.astype(np.float64)


def shaped(what: str, value: object, shape: tuple[int, ...], unit: str = "") -> Array:
    """A value as numbers of one shape.

    Raises:
        InvalidValueError: not a number or numbers.
        ShapeError: another shape.
    """
    numbers = as_numbers(what, value, unit)
    if numbers.shape != shape:
        raise ShapeError(what, numbers.shape, f"{shape}")
    return numbers


def within(what: str, value: object, bounds: tuple[float, float], unit: str) -> float:
    """A value as one number within bounds, which belong to what is allowed.

    Raises:
        InvalidValueError: not a number, or outside.
        ShapeError: more than one number.
    """
    number = float(shaped(what, value, (), unit))
    low, high = bounds
    if not low <= number <= high:
        raise InvalidValueError(what, number, f"{low:g} to {high:g}", unit)
    return number


def whole(what: str, value: object, least: int) -> int:
    """A value as a whole number, at least the least that is allowed.

    Raises:
        InvalidValueError: not a whole number, or below.
    """
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or value < least:
        raise InvalidValueError(what, value, f"a whole number, at least {least}")
    return int(value)
