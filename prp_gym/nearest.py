"""The valid name that a misspelt one is nearest to."""

import difflib
import re
from collections.abc import Iterable

_LONGEST_NAME = 100  # characters; a longer text is no misspelt name
_ALIKE = 0.6  # similarity from which one name may be meant by another
_PART_ALIKE = 0.8  # the same for a part of a name, which is easily similar to another by chance


def nearest_name(name: object, valid: Iterable[str]) -> str:
    """The valid name that is meant most likely; empty if none is near.

    Capitals do not count. A name may also be meant by a part of it: `force` by `PRP-Force-v0`.

    Args:
        name: what was given in place of a valid name.
        valid: the valid names.
    """
    if not isinstance(name, str) or not 0 < len(name) <= _LONGEST_NAME:
        return ""
    wanted, names = name.lower(), list(valid)
    lowered = {other.lower(): other for other in reversed(names)}
    near = difflib.get_close_matches(wanted, lowered, n=1, cutoff=_ALIKE)
    if near:
        return lowered[near[0]]
    parts = {part: other for other in reversed(names) for part in re.split(r"[^a-z0-9]+", other.lower())}
    near = difflib.get_close_matches(wanted, [part for part in parts if part], n=1, cutoff=_PART_ALIKE)
    return parts[near[0]] if near else ""
