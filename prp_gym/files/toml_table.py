"""`replace_table`: one table of a TOML file replaced, everything else kept, comments too."""

import json
import math
import re
from collections.abc import Mapping, Sequence
from typing import Any

from prp_gym.errors import InvalidValueError

_BARE = re.compile(r"[A-Za-z0-9_-]+")


def replace_table(text: str, key: Sequence[str], table: Mapping[str, Any]) -> str:
    """A text in TOML with one of its tables replaced, or put behind the last one that has the same parent.

    The table ends with the empty line behind it; it must not contain tables with a header of their own.

    Args:
        text: text in TOML in which the parent of the table has a header of its own.
        key: keys that lead to the table, the last one its own.
        table: texts, finite numbers, booleans, lists of these, and tables of these by name.

    Returns:
        the text, with numbers in their shortest form that reads back as the same.

    Raises:
        InvalidValueError: a value of another kind, or a text without the parent's header.
    """
    block = [f"[{_dotted(key)}]", *_lines(table)]
    lines = text.split("\n")
    starts = [index for index, line in enumerate(lines) if line.strip() == block[0]]
    if starts:
        begin = starts[0]
        return "\n".join([*lines[:begin], *block, *lines[_end(lines, begin) :]])
    parent = _dotted(key[:-1])
    family = [
        index
        for index, line in enumerate(lines)
        if line.strip() == f"[{parent}]" or line.strip().startswith(f"[{parent}.")
    ]
    if not family:
        raise InvalidValueError("TOML text", text[:80], f"a text with the header [{parent}]")
    end = _end(lines, family[-1])
    return "\n".join([*lines[:end], "", *block, *lines[end:]])


def _end(lines: Sequence[str], begin: int) -> int:
    """Index of the line behind a table: the first empty one, or the next header."""
    for index in range(begin + 1, len(lines)):
        if not lines[index].strip() or lines[index].startswith("["):
            return index
    return len(lines)


def _lines(table: Mapping[str, Any], prefix: str = "") -> list[str]:
    lines = []
    for name, value in table.items():
        if isinstance(value, Mapping):
            lines += _lines(value, f"{prefix}{_dotted([name])}.")
        else:
            lines.append(f"{prefix}{_dotted([name])} = {_value(name, value)}")
    return lines


def _value(name: str, value: Any) -> str:
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(_value(name, item) for item in value)}]"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, (int, float)) and math.isfinite(value):
        return repr(value)
    raise InvalidValueError(
        f"value of {name!r} for TOML", value, "a text, a finite number, a boolean or a list"
    )


def _dotted(key: Sequence[str]) -> str:
    return ".".join(part if _BARE.fullmatch(part) and "-" not in part else json.dumps(part) for part in key)
