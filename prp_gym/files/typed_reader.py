"""Plain values as dataclasses: no unknown key, none missing without a default, every value of its type."""

import difflib
import types
from collections.abc import Mapping
from dataclasses import MISSING, fields, is_dataclass
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, Union, get_args, get_origin, get_type_hints

from prp_gym.errors import DataFileError, PRPError, shortened

_NAMES = {str: "text", int: "a whole number", float: "a number", bool: "true or false", type(None): "null"}

_LONGEST_NAME = 200

ValueT = TypeVar("ValueT")


class TypedReader:
    """Reader of plain values, as files in JSON, TOML and YAML hold them, with the types of dataclasses.

    Args:
        path: path of the file, for messages.
        error: class of the error that is raised.
    """

    def __init__(self, path: Path, error: type[DataFileError] = DataFileError) -> None:
        self._path, self._error = path, error

    def read(self, kind: type[ValueT], plain: Any, key: str) -> ValueT:
        """An instance of a dataclass; a key may be missing where its field has a default.

        Args:
            kind: dataclass of the value.
            plain: value as the file holds it.
            key: position of the value in the file, for messages; empty for all of it.

        Raises:
            DataFileError: a missing or unknown key, a value of another type, or one that is not allowed.
        """
        value: ValueT = self._object(kind, plain, key)
        return value

    def members(
        self, plain: Any, key: str, names: set[str], optional: frozenset[str] = frozenset()
    ) -> dict[str, Any]:
        """The members of an object with the given keys and no others.

        Args:
            plain: value as the file holds it.
            key: position of the value in the file, for messages.
            names: all keys that the object may have.
            optional: those of the keys that may be missing.

        Raises:
            DataFileError: the value is not an object, or has other keys.
        """
        if not isinstance(plain, dict):
            raise self._refusal(key, plain, "an object")
        for name in sorted((plain.keys() ^ names) - optional):
            fault = "is missing" if name in names else f"is unknown{_nearest(name, names)}"
            raise self._error(self._path, f"key {shortened(_join(key, name))} {fault}")
        return plain

    def _object(self, kind: Any, plain: Any, key: str) -> Any:
        kinds, names, optional = _declaration(kind)
        plain = self.members(plain, key, set(names), optional)
        given = [name for name in names if name in plain]
        values = {name: self._value(kinds[name], plain[name], _join(key, name)) for name in given}
        try:
            return kind(**values)
        except PRPError as error:
            where = f"key {shortened(key)}: " if key else ""
            raise self._error(self._path, f"{where}{str(error).rstrip('.')}") from error

    def _value(self, kind: Any, plain: Any, key: str) -> Any:
        origin, arguments = get_origin(kind), get_args(kind)
        if kind is Any:
            return plain
        if is_dataclass(kind):
            return self._object(kind, plain, key)
        if origin is tuple:
            return self._items(arguments, plain, key)
        if origin is Mapping:
            items = self.members(plain, key, set(plain) if isinstance(plain, dict) else set())
            return {name: self._value(arguments[1], item, _join(key, name)) for name, item in items.items()}
        if origin in (Union, types.UnionType):
            return self._one_of(arguments, plain, key)
        return self._scalar(kind, plain, key)

    def _items(self, kinds: tuple[Any, ...], plain: Any, key: str) -> tuple[Any, ...]:
        """A list of any length with items of one type, or of a fixed length with a type for each item."""
        if not isinstance(plain, list):
            raise self._refusal(key, plain, "a list")
        each = kinds[:1] * len(plain) if kinds[-1] is Ellipsis else kinds
        if len(each) != len(plain):
            raise self._refusal(key, plain, f"a list of {len(each)} values")
        return tuple(
            self._value(kind, item, f"{key}[{n}]")
            for n, (kind, item) in enumerate(zip(each, plain, strict=True))
        )

    def _one_of(self, kinds: tuple[Any, ...], plain: Any, key: str) -> Any:
        """The value, read as the first of several types that it has."""
        for kind in kinds:
            wanted = list if get_origin(kind) is tuple else kind
            if type(plain) is wanted:
                return self._value(kind, plain, key)
        raise self._refusal(key, plain, "text, a number, true, false, null or a list of numbers")

    def _scalar(self, kind: type, plain: Any, key: str) -> Any:
        if kind is float and type(plain) is int:
            return float(plain)
        if type(plain) is not kind:  # `true` is not a number
            raise self._refusal(key, plain, _NAMES[kind])
        return plain

    def _refusal(self, key: str, plain: Any, expected: str) -> DataFileError:
        subject = f"key {shortened(key)}" if key else "the content"
        return self._error(self._path, f"{subject} is {shortened(plain)}; expected {expected}")


@cache
def _declaration(kind: Any) -> tuple[dict[str, Any], list[str], frozenset[str]]:
    """Types of a dataclass's fields by name, their names in order, and the names of those with a default."""
    own = fields(kind)
    defaults = (
        field.name for field in own if field.default is not MISSING or field.default_factory is not MISSING
    )
    return get_type_hints(kind), [field.name for field in own], frozenset(defaults)


def _nearest(name: str, names: set[str]) -> str:
    near = difflib.get_close_matches(name[:_LONGEST_NAME], names, n=1)
    return f"; did you mean {near[0]!r}?" if near else f"; allowed: {', '.join(sorted(names))}"


def _join(key: str, name: str) -> str:
    return f"{key}.{name}" if key else name
