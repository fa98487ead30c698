"""`parse_json`: JSON as RFC 8259 has it, without repeated keys, with finite numbers and a limited depth."""

import json
import math
import re
from typing import Any, NoReturn

from prp_gym.errors import DataTextError, shortened
from prp_gym.files.limits import DEPTH, INTEGER_DIGITS

_TOKENS = re.compile(r'"(?:[^"\\]++|\\.)*+"?|[\[\]{}]', re.DOTALL)
_STEPS = {"[": 1, "{": 1, "]": -1, "}": -1}


def parse_json(text: str) -> Any:
    """The value that a text in JSON stands for.

    Args:
        text: text of any origin.

    Raises:
        DataTextError: text that is not JSON, a key that is given twice, NaN or infinity, a whole number of
            more than `INTEGER_DIGITS` digits, or more than `DEPTH` levels.
    """
    _check_depth(text)
    try:
        return json.loads(
            text,
            object_pairs_hook=_unique,
            parse_float=_finite,
            parse_constant=_refuse_constant,
            parse_int=_whole,
        )
    except ValueError as fault:
        raise DataTextError("JSON", str(fault)) from None


def _check_depth(text: str) -> None:
    depth = 0
    for token in _TOKENS.finditer(text):
        depth += _STEPS.get(token[0], 0)
        if depth > DEPTH:
            raise DataTextError("JSON", f"it has more than {DEPTH} levels")


def _unique(members: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(members)
    if len(found) < len(members):
        names = [name for name, _ in members]
        twice = next(name for name in names if names.count(name) > 1)
        raise ValueError(f"key {shortened(twice)} is given twice")
    return found


def _finite(text: str) -> float:
    if not math.isfinite(number := float(text)):
        raise ValueError(f"{shortened(text)} is not a finite number")
    return number


def _whole(text: str) -> int:
    if len(text) > INTEGER_DIGITS:
        raise ValueError(f"{shortened(text)} has more than {INTEGER_DIGITS} digits")
    return int(text)


def _refuse_constant(name: str) -> NoReturn:
    raise ValueError(f"{name} is not a finite number")
