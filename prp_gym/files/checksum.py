"""The checksum of the files that this package writes in JSON."""

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from prp_gym.artifacts import to_plain
from prp_gym.errors import DataFileError

KEY = "checksum"
"""Key of the checksum beside the other keys of a file."""


def checksum(plain: Any) -> str:
    """SHA-256 of a value of strict JSON, in a form that does not depend on the order of its keys."""
    text = json.dumps(plain, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()


def seal(content: Mapping[str, Any]) -> dict[str, Any]:
    """The content of a file in types of strict JSON, with the checksum of all its keys as the last one.

    Args:
        content: values of any kind that `to_plain` takes, by text.
    """
    plain: dict[str, Any] = to_plain(content)
    return {**plain, KEY: checksum(plain)}


def unseal(path: Path, sealed: Any, error: type[DataFileError] = DataFileError) -> dict[str, Any]:
    """The content of a file without its checksum, once that is right.

    Args:
        path: path of the file, for messages.
        sealed: value that the file holds.
        error: class of the error that is raised.

    Raises:
        DataFileError: a value that is no object, or whose checksum is missing or wrong.
    """
    if not isinstance(sealed, dict) or KEY not in sealed:
        raise error(path, f"has no {KEY}: it is damaged, or this package did not write it")
    content = {name: value for name, value in sealed.items() if name != KEY}
    if sealed[KEY] != checksum(content):
        raise error(path, f"key {KEY!r} does not fit the rest: the file is damaged or altered")
    return content


def unseal_or_former(path: Path, content: Any, error: type[DataFileError] = DataFileError) -> Any:
    """The content of a file without its checksum, which version 0.1 did not write.

    Args:
        path: path of the file, for messages.
        content: value that the file holds; it must have the right checksum, or none.
        error: class of the error that is raised.

    Raises:
        DataFileError: an object with a wrong checksum.
    """
    return unseal(path, content, error) if isinstance(content, dict) and KEY in content else content
