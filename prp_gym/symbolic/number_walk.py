"""`NumberWalk`: the numbers that objects hold, and what the objects are apart from them."""

import copy
import enum
import pickle
from collections.abc import Callable, Hashable, Iterable
from types import FunctionType, MethodType, ModuleType
from typing import Any

import numpy as np

from prp_gym.errors import UntraceableError
from prp_gym.symbolic.array import SymbolicArray

_KNOWN_BY_VALUE = (bool, int, str, bytes, range, type(None))
_KNOWN_BY_NAME = (enum.Enum, type, FunctionType, ModuleType, np.ufunc)
_STRUCTURE = (*_KNOWN_BY_VALUE, *_KNOWN_BY_NAME)


class _Identity:
    """An object as one that equals nothing else.

    Args:
        value: the object.
    """

    def __init__(self, value: object) -> None:
        self._value = value

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Identity) and self._value is other._value

    def __hash__(self) -> int:
        return id(self._value)


class NumberWalk:
    """A copy of objects in which every real number is replaced.

    Numbers are floats and arrays of float64, wherever attributes, bound methods, tuples, lists and
    dictionaries lead. All else is structure, and is copied where a formula may change it; objects of the
    classes `constants` stay as they are.

    Args:
        replace: function of a number or an array of them, in the order in which they are found.
        constants: classes of objects whose numbers are constants.

    Attributes:
        structure: what the objects are apart from their numbers.
    """

    def __init__(self, replace: Callable[[Any], Any], constants: tuple[type, ...] = ()) -> None:
        self._replace, self._constants = replace, constants
        self._known: dict[int, Any] = {}
        self._kept: list[object] = []  # so that no address is used twice
        self.structure: list[Hashable] = []

    def leave(self, value: object) -> None:
        """Leave an object as it is wherever it is found."""
        self._kept.append(value)
        self._keep(value, value)

    def copied(self, value: Any) -> Any:
        """The copy of a value.

        Raises:
            UntraceableError: a value that holds something of which no copy can be made.
        """
        kind = type(value)
        if isinstance(value, float) and not isinstance(value, enum.Enum):
            self.structure.append("number")
            return self._replace(float(value))
        if isinstance(value, SymbolicArray) or (kind is np.ndarray and value.dtype == np.float64):
            self.structure.append(("numbers", value.shape))
            return self._replace(value)
        if isinstance(value, _STRUCTURE):
            self.structure.append((kind, value))
            return value
        if isinstance(value, self._constants):
            self.structure.append((kind, _pickled(value)))
            return value
        if id(value) in self._known:
            self.structure.append(("again", list(self._known).index(id(value))))
            return self._known[id(value)]
        self._kept.append(value)
        self.structure.append((kind,))
        return self._of_parts(value)

    def _of_parts(self, value: Any) -> Any:
        """The copy of a container, a bound method or an object, part by part."""
        kind = type(value)
        if kind is tuple or (isinstance(value, tuple) and hasattr(kind, "_make")):
            self.structure.append(len(value))
            parts = [self.copied(part) for part in value]
            return self._keep(value, tuple(parts) if kind is tuple else kind._make(parts))
        if kind is list:
            self.structure.append(len(value))
            row: list[Any] = self._keep(value, [])
            row.extend(self.copied(part) for part in value)
            return row
        if kind is dict:
            table: dict[Any, Any] = self._keep(value, {})
            table.update(self._named(value.items()))
            return table
        if kind is MethodType:
            self.structure.append(value.__func__)
            return self._keep(value, MethodType(value.__func__, self.copied(value.__self__)))
        return self._of_object(value)

    def _of_object(self, value: Any) -> Any:
        """The copy of an object, attribute by attribute; a deep one where it has more than attributes."""
        try:
            made = object.__new__(type(value))
        except TypeError:  # a class that is not written in Python, or has a base that is not
            self.structure.append(_pickled(value))
            return self._keep(value, copy.deepcopy(value))
        parts = attributes_of(value)
        if not parts:  # nothing that could change, but an identity
            self.structure.append(_Identity(value))
            return self._keep(value, value)
        self._keep(value, made)
        for name, part in self._named(parts.items()):
            object.__setattr__(made, name, part)
        return made

    def _named(self, items: Iterable[tuple[Hashable, Any]]) -> Iterable[tuple[Any, Any]]:
        """Names with the copies of what they name."""
        every = list(items)
        self.structure.append(tuple(name for name, _ in every))
        return [(name, self.copied(part)) for name, part in every]

    def _keep(self, value: Any, made: Any) -> Any:
        """Note the copy of a value, and return it."""
        self._known[id(value)] = made
        return made


def attributes_of(value: object) -> dict[str, Any]:
    """The attributes of an object by name, those in slots among them."""
    state: Any = object.__getstate__(value)
    attributes, slots = state if isinstance(state, tuple) else (state, None)
    return {**(attributes or {}), **(slots or {})}


def _pickled(value: Any) -> bytes:
    """What tells a value from others of its class.

    Raises:
        UntraceableError: a value that cannot be pickled.
    """
    try:
        return pickle.dumps(value)
    except Exception as error:  # whatever the value's own methods raise
        kept = f"an object that holds a {type(value).__name__}"
        raise UntraceableError(f"{kept} cannot be traced into compiled code: {error}.") from error
