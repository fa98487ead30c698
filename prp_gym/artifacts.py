"""Artifacts: strict JSON and other files, and how they are written atomically."""

import json
import math
import os
import platform
import tempfile
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, is_dataclass
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from prp_gym.errors import OutputError
from prp_gym.processes.leftovers import part_of

_PACKAGES = ("prp-gym", "gymnasium", "mujoco", "numpy")


def to_plain(value: Any) -> Any:
    """A value in the types of strict JSON; NaN becomes null, infinity the text "inf" or "-inf"."""
    if is_dataclass(value) and not isinstance(value, type):
        return to_plain(asdict(value))
    if isinstance(value, Mapping):
        return {str(key): to_plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray):
        return to_plain(value.tolist())
    if isinstance(value, (list, tuple)):
        return [to_plain(item) for item in value]
    if isinstance(value, np.generic):
        return to_plain(value.item())
    if isinstance(value, float) and not math.isfinite(value):
        return None if math.isnan(value) else str(value)
    return value


def to_array(plain: Sequence[Any]) -> NDArray[np.float64]:
    """An array from numbers that `to_plain` has converted, or from nested lists of them."""
    return np.array(plain, dtype=np.float64)  # numpy reads None as NaN and "inf" as infinity


def list_versions() -> dict[str, str]:
    """Versions of Python and of the packages that a result depends on."""
    return {"python": platform.python_version()} | {name: _installed_version(name) for name in _PACKAGES}


@cache
def _installed_version(package: str) -> str:
    """The version of a package, whose metadata, thousands of lines, are read once in a process."""
    return version(package)


def prepare_folder(folder: Path) -> None:
    """Make a folder for results, before the work that writes into it.

    Raises:
        OutputError: it cannot be made or written to.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=folder).close()
    except OSError as error:
        raise OutputError(folder, error) from error


def require_folder(folder: Path) -> None:
    """Check that a folder is still there, before a file of a run is written into it.

    Raises:
        OutputError: somebody has removed or renamed it.
    """
    if not folder.is_dir():
        raise OutputError(folder, "the folder was removed or renamed during the run")


def write_json(path: Path, content: Mapping[str, Any]) -> None:
    """Write a JSON file atomically: it is complete, or it does not exist.

    Args:
        path: path of the file; its folder is made if it does not exist.
        content: value of any kind that `to_plain` takes.

    Raises:
        OutputError: the folder cannot be made or written to.
    """
    text = json.dumps(to_plain(content), indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    write_file(path, text.encode())


def write_file(path: Path, content: bytes) -> None:
    """Write a file atomically: it is complete, or it does not exist.

    Args:
        path: path of the file; its folder is made if it does not exist.
        content: bytes of the file.

    Raises:
        OutputError: the folder cannot be made or written to.
    """
    part = part_of(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with part.open("wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())  # or a crash of the machine could leave a name without content
        os.replace(part, path)
    except OSError as error:
        raise OutputError(path, error) from error
    finally:
        with suppress(OSError):  # it is not there, or has no folder
            part.unlink()
