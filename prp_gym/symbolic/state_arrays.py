"""Arrays that objects keep from one period to the next, as one row of numbers for each environment."""

from collections.abc import Collection, Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol

import numpy as np

from prp_gym.errors import UntraceableError
from prp_gym.symbolic.array import SymbolicArray
from prp_gym.symbolic.number_walk import NumberWalk, attributes_of


class Stateful(Protocol):
    """What keeps arrays.

    Attributes:
        state_arrays: names of the attributes, each with its axis of environments.
    """

    state_arrays: ClassVar[Mapping[str, int]]


@dataclass(frozen=True)
class StateArray:
    """One array in a row.

    Attributes:
        owner: position of the object in a sequence of objects.
        name: name of the attribute.
        axis: axis of environments.
        shape: shape of one environment's part.
        boolean: whether it holds truth values.
        columns: columns of the row.
        first: order of the array's axes that begins with that of environments.
        back: order of those axes that gives the array again.
    """

    owner: int
    name: str
    axis: int
    shape: tuple[int, ...]
    boolean: bool
    columns: slice
    first: tuple[int, ...]
    back: tuple[int, ...]


class StateRows:
    """The arrays of several objects as rows.

    Args:
        owners: objects whose arrays have the shapes of an episode.

    Attributes:
        arrays: the arrays in the order of the columns.
        size: number of columns.
    """

    def __init__(self, owners: Sequence[Stateful]) -> None:
        self.arrays: list[StateArray] = []
        self.size = 0
        for index, owner in enumerate(owners):
            for name, axis in owner.state_arrays.items():
                values = getattr(owner, name)
                shape = values.shape[:axis] + values.shape[axis + 1 :]
                last = self.size + int(np.prod(shape, dtype=np.intp))
                boolean, columns = values.dtype == np.bool_, slice(self.size, last)
                first = (axis, *(other for other in range(values.ndim) if other != axis))
                back = tuple(first.index(own) for own in range(values.ndim))
                self.arrays.append(StateArray(index, name, axis, shape, boolean, columns, first, back))
                self.size = last

    def read(self, owners: Sequence[Any]) -> Any:
        """The rows (N, size) of arrays, of numbers or symbolic."""
        parts = []
        for array in self.arrays:
            values = getattr(owners[array.owner], array.name).astype(np.float64)
            moved = np.transpose(values, array.first) if array.axis else values
            parts.append(moved.reshape((moved.shape[0], -1)))
        return np.concatenate(parts, axis=1) if parts else np.zeros((1, 0))

    def clear(self, owners: Sequence[Any]) -> None:
        """Remove the arrays from objects."""
        for array in self.arrays:
            setattr(owners[array.owner], array.name, None)

    def write(self, owners: Sequence[Any], rows: Any) -> None:
        """Replace the arrays by those in rows (N, size), of numbers or symbolic."""
        for array in self.arrays:
            part = rows[:, array.columns].reshape((len(rows), *array.shape))
            values = np.transpose(part, array.back) if array.axis else part
            kept = values.astype(np.bool_) if array.boolean else values.copy()
            setattr(owners[array.owner], array.name, kept)

    def require_unchanged(self, owners: Sequence[Any], before: Sequence[Mapping[str, Any]]) -> None:
        """Refuse objects that keep something else than their declared arrays.

        Args:
            owners: objects after a period.
            before: what `attributes` returned before it.

        Raises:
            UntraceableError: an object with another attribute that the period has changed.
        """
        for index, (owner, known) in enumerate(zip(owners, before, strict=True)):
            require_same(owner, known, {array.name for array in self.arrays if array.owner == index})


def require_same(owner: Any, before: Mapping[str, Any], declared: Collection[str] = ()) -> None:
    """Refuse an object that a formula has changed.

    Args:
        owner: object after the formula has run.
        before: what `attributes` returned before.
        declared: names of attributes that may change.

    Raises:
        UntraceableError: an object with another attribute that has changed.
    """
    after = attributes(owner)
    for name in {**before, **after}:
        if name not in declared and before.get(name) != after.get(name):
            kept = f"{type(owner).__name__} keeps {name!r} from one call to the next"
            raise UntraceableError(f"{kept}, which cannot be traced into compiled code.")


def attributes(owner: Any) -> dict[str, Hashable]:
    """What the attributes of an object hold, whatever leads to it.

    Raises:
        UntraceableError: an attribute of which this cannot be told.
    """
    return {name: _content(owner, value) for name, value in attributes_of(owner).items()}


def _content(owner: Any, value: Any) -> Hashable:
    """What an attribute of an object holds: numbers, expressions, and what is around them."""
    found: list[Hashable] = []

    def note(numbers: Any) -> Any:
        symbolic = isinstance(numbers, SymbolicArray)
        found.append(tuple(numbers.flat()) if symbolic else np.asarray(numbers).tobytes())
        return numbers

    walk = NumberWalk(note)
    walk.leave(owner)
    walk.copied(value)
    return tuple(walk.structure), tuple(found)
