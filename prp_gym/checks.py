"""Checks of what users give: one for each kind of value; their errors name value, unit and bounds."""

import math
from collections.abc import Collection, Sized
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from prp_gym.errors import InvalidValueError, NonFiniteError, ShapeError, UnknownNameError
from prp_gym.symbolic.array import is_symbolic

Array = NDArray[np.float64]
KindT = TypeVar("KindT")

LARGEST = 1e30
"""Largest magnitude of a number that is computed with: no product of the formulas' factors overflows."""

LARGEST_SEED = 2**128 - 1
"""Largest random seed: NumPy draws seeds of 128 bits."""

LARGEST_WHOLE = 2**63 - 1
"""Largest whole number, that of an array of integers."""

_FLOAT64 = np.dtype(np.float64)

PLAIN = (np.dtype(np.float32), _FLOAT64)
"""Types of arrays whose values are numbers that need no check of their kind."""

_MOST_NUMBERS = 10**7  # that are converted from something else than an array
_FEW = 16  # numbers, up to which a loop in Python is faster than one of NumPy
_LONGEST_TEXT = 10_000  # characters
_COUNTS = {1: "one number", 3: "three numbers", 6: "six numbers"}


def as_numbers(what: str, value: object, unit: str = "") -> Array:
    """Convert a value to a new array of numbers; texts, booleans and complex numbers are refused.

    Args:
        what: name of the value, for messages.
        value: value as the user gives it.
        unit: unit of the numbers.

    Raises:
        InvalidValueError: a value that is neither a number nor an array of numbers.
    """
    if type(value) is np.ndarray and value.dtype in PLAIN:
        return value.astype(np.float64)
    numbers = _array(value)
    if numbers.dtype.kind not in "iuf":
        raise InvalidValueError(what, value, "a number or numbers", unit)
    if numbers.dtype.itemsize <= 8:
        return numbers.astype(np.float64)
    with np.errstate(over="ignore"):  # longer floating-point numbers may exceed float64, and become infinite
        return numbers.astype(np.float64)


def _array(value: object) -> NDArray[np.generic]:
    """A value as an array; one of objects where it is none."""
    if isinstance(value, np.ma.MaskedArray):  # its values are not all meant
        return np.asarray(None)
    if isinstance(value, np.ndarray):
        return np.asarray(value)
    try:
        if isinstance(value, Sized) and len(value) > _MOST_NUMBERS:
            return np.asarray(None)
        return np.asarray(value)
    except Exception:  # rows of different lengths, or whatever the value's own methods raise
        return np.asarray(None)


def as_array(what: str, value: object, unit: str = "") -> Array:
    """Convert a value to an array of numbers, without a copy where it is one already.

    Raises:
        InvalidValueError: a value that is neither a number nor an array of numbers.
    """
    if type(value) is np.ndarray and value.dtype is _FLOAT64:
        return value
    if is_symbolic(value):
        symbolic: Any = value
        traced: Array = symbolic
        return traced
    return as_numbers(what, value, unit)


def check_finite(what: str, numbers: Array, unit: str = "", largest: float = LARGEST) -> None:
    """Refuse numbers that are not finite, or so large that a product of them overflows.

    Raises:
        NonFiniteError: NaN or infinity.
        InvalidValueError: a magnitude above the largest allowed one.
    """
    if is_symbolic(numbers):
        return
    if numbers.size <= _FEW:
        if math.hypot(*numbers.ravel().tolist()) <= largest:
            return
    elif np.vdot(numbers, numbers) <= largest * largest:  # cannot be NaN then; BLAS warns of no overflow
        return
    if not np.isfinite(numbers).all():
        raise NonFiniteError(what, numbers.tolist())
    if np.abs(numbers).max(initial=0.0) > largest:
        raise InvalidValueError(what, numbers.tolist(), f"magnitudes up to {largest:g}", unit)


def finite(what: str, value: object, unit: str = "", largest: float = LARGEST) -> Array:
    """Convert a value to a new array of finite numbers.

    Raises:
        InvalidValueError: a value that is neither a number nor an array of numbers, or a magnitude above the
            largest allowed one.
        NonFiniteError: NaN or infinity.
    """
    numbers = as_numbers(what, value, unit)
    check_finite(what, numbers, unit, largest)
    return numbers


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


def bounded(what: str, value: object, bounds: tuple[float, float], unit: str) -> Array:
    """Convert a value to numbers within bounds, which are allowed themselves.

    Raises:
        InvalidValueError: a value that is neither a number nor an array of numbers, or is out of bounds.
    """
    numbers = as_numbers(what, value, unit)
    low, high = bounds
    if not ((numbers >= low) & (numbers <= high)).all():
        raise InvalidValueError(what, value, f"{low:g} to {high:g}", unit)
    return numbers


def each_within(what: str, numbers: Array, bounds: tuple[float, float], unit: str) -> Array:
    """Refuse numbers (n), one for each of n environments, outside bounds, which are allowed themselves.

    Raises:
        InvalidValueError: a number out of bounds; the first one is named.
    """
    low, high = bounds
    good = (numbers >= low) & (numbers <= high)
    if np.count_nonzero(good) < numbers.size:
        raise InvalidValueError(what, float(numbers[~good][0]), f"{low:g} to {high:g}", unit)
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


def components(
    what: str, value: object, count: int, bounds: tuple[float, float], unit: str
) -> tuple[float, ...]:
    """Convert a value to a given number of numbers within bounds, which are allowed themselves.

    Raises:
        InvalidValueError: another number of numbers, values that are not numbers, or out of bounds.
    """
    numbers = bounded(what, value, bounds, unit)
    if numbers.shape != (count,):
        expected = _COUNTS.get(count, f"{count} numbers")
        raise InvalidValueError(what, value, expected, unit)
    return tuple(numbers.tolist())


def whole(what: str, value: object, least: int, most: int = LARGEST_WHOLE, unit: str = "") -> int:
    """Convert a value to a whole number within bounds, which are allowed themselves.

    Raises:
        InvalidValueError: a value that is not a whole number, or is out of bounds.
    """
    if not _is_whole(value) or not least <= value <= most:  # type: ignore[operator]
        highest = "" if most == LARGEST_WHOLE else f", at most {most}"
        raise InvalidValueError(what, value, f"a whole number, at least {least}{highest}", unit)
    return int(value)  # type: ignore[call-overload, no-any-return]


def random_seed(what: str, value: object) -> int:
    """Convert a value to a random seed.

    Raises:
        InvalidValueError: a value that is not a whole number, is negative, or has more than 128 bits.
    """
    if not _is_whole(value) or not 0 <= value <= LARGEST_SEED:  # type: ignore[operator]
        raise InvalidValueError(what, value, "a whole number, at least 0, of at most 128 bits")
    return int(value)  # type: ignore[call-overload, no-any-return]


def _is_whole(value: object) -> bool:
    """Whether a value is an integer, of Python or NumPy; a time difference of NumPy is none."""
    return isinstance(value, (int, np.integer)) and not isinstance(value, (bool, np.timedelta64))


def choice(what: str, value: object, valid: Collection[str]) -> str:
    """Convert a value to one of several words.

    Raises:
        UnknownNameError: a value that is none of the words, or not a text.
    """
    if not isinstance(value, str) or value not in valid:
        raise UnknownNameError(what, value, valid)
    return str(value)


def flag(what: str, value: object) -> bool:
    """Convert a value to a truth value.

    Raises:
        InvalidValueError: a value that is neither True nor False.
    """
    if not isinstance(value, (bool, np.bool_)):
        raise InvalidValueError(what, value, "True or False")
    return bool(value)


def text(what: str, value: object) -> str:
    """Convert a value to a text.

    Raises:
        InvalidValueError: a value that is not a text, is empty or too long.
    """
    if not isinstance(value, str) or not 0 < len(value) <= _LONGEST_TEXT:
        raise InvalidValueError(what, value, f"a text of 1 to {_LONGEST_TEXT} characters")
    return str(value)


def instance(what: str, value: object, kind: type[KindT]) -> KindT:
    """Refuse what is not of a class.

    Raises:
        InvalidValueError: a value of another class.
    """
    if not isinstance(value, kind):
        raise InvalidValueError(what, value, f"of class {kind.__name__}")
    return value


def random_generator(what: str, value: object) -> np.random.Generator:
    """Refuse what is not a random generator of NumPy.

    Raises:
        InvalidValueError: any other value.
    """
    if not isinstance(value, np.random.Generator):
        raise InvalidValueError(what, value, "a numpy.random.Generator")
    return value
