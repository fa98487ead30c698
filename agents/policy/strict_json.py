"""Strict reading of JSON as dataclasses: no unknown key, none missing without a default, numbers finite."""

import json
import math
import types
from collections.abc import Mapping
from dataclasses import MISSING, fields, is_dataclass
from pathlib import Path
from typing import Any, TypeVar, Union, get_args, get_origin, get_type_hints

from prp_gym.errors import AgentFileError, PRPError

_NAMES = {str: "text", int: "a whole number", float: "a number", bool: "true or false", type(None): "null"}

ValueT = TypeVar("ValueT")


def parse_json(path: Path, content: bytes) -> Any:
    """The value that a JSON file holds.

    Args:
        path: path of the file, for messages.
        content: content of the file.

    Raises:
        AgentFileError: the content is not JSON, has a key twice, or has NaN or infinity.
    """

    def unique(members: list[tuple[str, Any]]) -> dict[str, Any]:
        found = dict(members)
        if len(found) < len(members):
            raise ValueError(f"a key is given twice in {[key for key, _ in members]}")
        return found

    def finite(text: str) -> float:
        if not math.isfinite(number := float(text)):
            raise ValueError(f"{text} is not a finite number")
        return number

    try:
        text = content.decode("utf-8")
        return json.loads(text, object_pairs_hook=unique, parse_float=finite, parse_constant=finite)
    except (ValueError, RecursionError) as error:
        raise AgentFileError(path, f"is not a JSON file: {error}") from None


class StrictReader:
    """Reader of plain JSON values as dataclasses with the declared types.

    Args:
        path: path of the file, for messages.
    """

    def __init__(self, path: Path) -> None:
        self._path = path

    def read(self, kind: type[ValueT], plain: Any, key: str) -> ValueT:
        """An instance of a dataclass; a key may be missing where its field has a default.

        Args:
            kind: dataclass of the value.
            plain: value as JSON represents it.
            key: position of the value in the file, for messages.

        Raises:
            AgentFileError: a missing or unknown key, a value of another type, or one that is not allowed.
        """
        value: ValueT = self._object(kind, plain, key)
        return value

    def members(
        self, plain: Any, key: str, names: set[str], optional: frozenset[str] = frozenset()
    ) -> dict[str, Any]:
        """The members of a JSON object with the given keys and no others.

        Args:
            plain: value as JSON represents it.
            key: position of the value in the file, for messages.
            names: all keys that the object may have.
            optional: those of the keys that may be missing.

        Raises:
            AgentFileError: the value is not an object, or has other keys.
        """
        if not isinstance(plain, dict):
            raise self._refusal(key, plain, "an object")
        for name in sorted((plain.keys() ^ names) - optional):
            fault = "is missing" if name in names else "is unknown"
            raise AgentFileError(self._path, f"key {_join(key, name)!r} {fault}")
        return plain

    def _object(self, kind: Any, plain: Any, key: str) -> Any:
        kinds = get_type_hints(kind)
        names = [field.name for field in fields(kind)]
        plain = self.members(plain, key, set(names), _names_with_default(kind))
        given = [name for name in names if name in plain]
        values = {name: self._value(kinds[name], plain[name], _join(key, name)) for name in given}
        try:
            return kind(**values)
        except PRPError as error:
            raise AgentFileError(self._path, f"key {key!r}: {str(error).rstrip('.')}") from error

    def _value(self, kind: Any, plain: Any, key: str) -> Any:
        origin, arguments = get_origin(kind), get_args(kind)
        if kind is Any:
            return plain
        if is_dataclass(kind):
            return self._object(kind, plain, key)
        if origin is tuple:
            if not isinstance(plain, list):
                raise self._refusal(key, plain, "a list")
            return tuple(self._value(arguments[0], item, f"{key}[{n}]") for n, item in enumerate(plain))
        if origin is Mapping:
            items = self.members(plain, key, set(plain) if isinstance(plain, dict) else set())
            return {name: self._value(arguments[1], item, _join(key, name)) for name, item in items.items()}
        if origin in (Union, types.UnionType):
            return self._one_of(arguments, plain, key)
        return self._scalar(kind, plain, key)

    def _one_of(self, kinds: tuple[Any, ...], plain: Any, key: str) -> Any:
        """The value, read as the first of several types that it has."""
        for kind in kinds:
            wanted = list if get_origin(kind) is tuple else kind
            if type(plain) is wanted:
                return self._value(kind, plain, key)
        raise self._refusal(key, plain, "text, a number, true, false, null or a list of numbers")

    def _scalar(self, kind: type, plain: Any, key: str) -> Any:
        if kind is float and type(plain) is int:
            try:
                return float(plain)
            except OverflowError:
                raise self._refusal(key, plain, _NAMES[kind]) from None
        if type(plain) is not kind:  # `true` is not a number
            raise self._refusal(key, plain, _NAMES[kind])
        return plain

    def _refusal(self, key: str, plain: Any, expected: str) -> AgentFileError:
        shown = repr(plain)
        shown = shown if len(shown) <= 80 else f"{shown[:77]}..."
        return AgentFileError(self._path, f"key {key!r} is {shown}; expected {expected}")


def _names_with_default(kind: Any) -> frozenset[str]:
    """Names of a dataclass's fields that have a default value."""
    return frozenset(field.name for field in fields(kind) if field.default is not MISSING)


def _join(key: str, name: str) -> str:
    return f"{key}.{name}" if key else name
