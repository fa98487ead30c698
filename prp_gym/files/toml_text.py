"""`parse_toml`: TOML with plain values alone, of a limited depth."""

import re
import tomllib
from collections.abc import Iterator
from typing import Any

from prp_gym.errors import DataTextError, shortened
from prp_gym.files.limits import DEPTH, INTEGER_DIGITS

_TOKENS = re.compile(
    r'"""(?:[^"\\]++|\\.|"(?!""))*+(?:""")?'
    r"|'''(?:[^']++|'(?!''))*+(?:''')?"
    r'|"(?:[^"\\\n]++|\\[^\n])*+"?'
    r"|'[^'\n]*+'?"
    r"|#[^\n]*+|[\[\]{}.=,\n]",
    re.DOTALL,
)
"""Texts, comments and the characters between which keys stand."""

_STEPS = {"[": 1, "{": 1, "]": -1, "}": -1}
_LARGEST = 10**INTEGER_DIGITS


def parse_toml(text: str) -> dict[str, Any]:
    """The table that a text in TOML stands for.

    Args:
        text: text of any origin.

    Raises:
        DataTextError: text that is not TOML, a date or time, a whole number of more than `INTEGER_DIGITS`
            digits, or more than `DEPTH` levels.
    """
    _check_depth(text)
    try:
        table = tomllib.loads(text)
    except (ValueError, RecursionError) as fault:
        raise DataTextError("TOML", str(fault)) from None
    for value in _leaves(table):
        if type(value) not in (str, int, float, bool):
            raise DataTextError(
                "TOML", f"{shortened(str(value))} is a {type(value).__name__}, not a number or text"
            )
        if type(value) is int and abs(value) >= _LARGEST:
            raise DataTextError("TOML", f"a whole number has more than {INTEGER_DIGITS} digits")
    return table


def _check_depth(text: str) -> None:
    """Refuse nesting in brackets or in dotted keys, before a recursive function reads it."""
    depth = dots = 0
    for token in _TOKENS.finditer(text):
        depth += _STEPS.get(token[0], 0)
        if token[0] == ".":
            dots += 1
        elif token[0][0] not in "\"'#":
            dots = 0
        if max(depth, dots) > DEPTH:
            raise DataTextError("TOML", f"it has more than {DEPTH} levels")


def _leaves(table: dict[str, Any]) -> Iterator[Any]:
    waiting: list[Any] = [table]
    while waiting:
        value = waiting.pop()
        if isinstance(value, dict):
            waiting += value.values()
        elif isinstance(value, list):
            waiting += value
        else:
            yield value
