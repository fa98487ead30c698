"""Nested tuples of arrays as one row of numbers for each environment."""

from typing import Any

import numpy as np

from prp_gym.errors import UntraceableError
from prp_gym.symbolic.array import SymbolicArray, untraceable
from prp_gym.symbolic.single_array import SingleArray

_KINDS = (np.dtype(np.float64), np.dtype(np.float32), np.dtype(np.bool_))
"""Arrays whose values a row of float64 holds exactly and compiled code computes."""


class NestedRows:
    """Values that are None, arrays, or tuples of such values, as rows.

    Args:
        values: values with N environments along the first axis of every array.
        count: number of environments N.

    Attributes:
        structure: what the values are apart from their numbers.
        size: number of columns.

    Raises:
        UntraceableError: values of another kind.
    """

    def __init__(self, values: Any, count: int) -> None:
        self.structure = _structure(values, count)
        self.size = sum(_size(shape) for shape, _ in _leaves(self.structure))

    def fit(self, values: Any, count: int) -> bool:
        """Whether these rows hold values, with their shapes and types."""
        try:
            return bool(_structure(values, count) == self.structure)
        except UntraceableError:
            return False

    def read(self, values: Any, count: int) -> Any:
        """The rows (N, size) of values, of numbers or symbolic.

        Raises:
            UntraceableError: symbolic values of another structure.
        """
        parts: list[Any] = [np.zeros((count, 0))]
        self._collect(self.structure, values, count, parts)
        return np.concatenate(parts, axis=1)

    def write(self, rows: Any) -> Any:
        """The values in rows (N, size), of numbers or symbolic; new arrays."""
        made, _ = _made(self.structure, rows, 0)
        return made

    def _collect(self, structure: Any, values: Any, count: int, parts: list[Any]) -> None:
        """Add the columns of values to parts."""
        if structure is None:
            if values is not None:
                raise untraceable("a memory whose structure changes")
        elif structure[0] is np.ndarray:
            _, shape, kind = structure
            if not _is_of(kind, values) or values.shape != (count, *shape):
                raise untraceable("a memory whose arrays change their shapes or types")
            parts.append(values.astype(np.float64).reshape((count, _size(shape))))
        else:
            container, inner = structure
            if type(values) is not container or len(values) != len(inner):
                raise untraceable("a memory whose structure changes")
            for part, value in zip(inner, values, strict=True):
                self._collect(part, value, count, parts)


def _structure(values: Any, count: int) -> Any:
    """What values are apart from their numbers, which can be compared."""
    if values is None:
        return None
    if type(values) is np.ndarray:
        if values.shape[:1] != (count,) or values.dtype not in _KINDS:
            raise untraceable(f"a memory with an array of shape {values.shape} and type {values.dtype}")
        return np.ndarray, values.shape[1:], values.dtype
    if type(values) is tuple or (isinstance(values, tuple) and hasattr(type(values), "_make")):
        return type(values), tuple(_structure(value, count) for value in values)
    raise untraceable(f"a memory with a {type(values).__name__}")


def _is_of(kind: np.dtype[Any], values: Any) -> bool:
    """Whether a value is an array of a type; truth values may have become symbolic numbers."""
    if isinstance(values, np.ndarray):
        return bool(values.dtype == kind)
    return isinstance(values, SymbolicArray) and isinstance(values, SingleArray) == (kind == np.float32)


def _leaves(structure: Any) -> list[Any]:
    """Shapes and types of the arrays."""
    if structure is None:
        return []
    if structure[0] is np.ndarray:
        return [structure[1:]]
    return [leaf for part in structure[1] for leaf in _leaves(part)]


def _made(structure: Any, rows: Any, first: int) -> tuple[Any, int]:
    """Values from the columns of rows from the first on, and the column after them."""
    if structure is None:
        return None, first
    if structure[0] is np.ndarray:
        _, shape, kind = structure
        last = first + _size(shape)
        part: Any = rows[:, first:last].reshape((len(rows), *shape))
        return (part.copy() if kind == np.float64 else part.astype(kind)), last
    container, inner = structure
    values = []
    for part in inner:
        value, first = _made(part, rows, first)
        values.append(value)
    return (tuple(values) if container is tuple else container._make(values)), first


def _size(shape: tuple[int, ...]) -> int:
    return int(np.prod(shape, dtype=np.intp))
