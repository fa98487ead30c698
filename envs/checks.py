"""Checks that turn keywords and reset options into numbers."""

import numpy as np

from prp_gym.errors import InvalidValueError, ShapeError
from prp_gym.robot.arrays import Array


def as_numbers(what: str, value: object, unit: str = "") -> Array:
    """Convert a value to an array of numbers; strings and booleans are refused.

    Raises:
        InvalidValueError: a value that is neither a number nor an array of numbers.
    """
    try:
        numbers = np.asarray(value)
    except ValueError:  # rows of different lengths
        numbers = np.asarray(None)
    if numbers.dtype.kind not in "iuf":
        raise InvalidValueError(what, value, "a number or numbers", unit)
    return numbers.astype(np.float64)


def shaped(what: str, value: object, shape: tuple[int, ...], unit: str = "") -> Array:
    """Convert a value to numbers of a given shape.

    Raises:
        InvalidValueError: a value that is neither a number nor an array of numbers.
        ShapeError: a value of another shape.
    """
    numbers = as_numbers(what, value, unit)
    if numbers.shape != shape:
        raise ShapeError(what, numbers.shape, f"{shape}")
    return numbers


def within(what: str, value: object, bounds: tuple[float, float], unit: str) -> float:
    """Convert a value to one number within bounds, which are allowed themselves.

    Raises:
        InvalidValueError: a value that is not a number, or is out of bounds.
        ShapeError: more than one number.
    """
    number = float(shaped(what, value, (), unit))
    low, high = bounds
    if not low <= number <= high:
        raise InvalidValueError(what, number, f"{low:g} to {high:g}", unit)
    return number


def whole(what: str, value: object, least: int) -> int:
    """Convert a value to a whole number that is not below the least allowed one.

    Raises:
        InvalidValueError: a value that is not a whole number, or is below `least`.
    """
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or value < least:
        raise InvalidValueError(what, value, f"a whole number, at least {least}")
    return int(value)
