"""Artifacts: files that are strict, complete and written in one piece, and how they are read back."""

import json
import math
import os
import platform
import tempfile
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, is_dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from prp_gym.errors import InvalidValueError, OutputError

_PACKAGES = ("prp-gym", "gymnasium", "mujoco", "numpy")


def to_plain(value: Any) -> Any:
    """A value as strict JSON knows it; NaN becomes null, infinity the text "inf" or "-inf"."""
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
    """Numbers as `to_plain` leaves them, or nested lists of such, as an array again."""
    return np.array(plain, dtype=np.float64)  # numpy reads None as NaN and "inf" as infinity


def list_versions() -> dict[str, str]:
    """Versions of Python and of the packages that a result depends on."""
    return {"python": platform.python_version()} | {name: version(name) for name in _PACKAGES}


def prepare_folder(folder: Path) -> None:
    """Make a folder for results, before the work whose results it is to hold.

    Raises:
        OutputError: it cannot be made or written to.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=folder).close()
    except OSError as error:
        raise OutputError(folder, error) from error


def write_json(path: Path, content: Mapping[str, Any]) -> None:
    """Write a JSON file so that it is either whole or not there.

    Args:
        path: path of the file; its folder is made if it does not exist.
        content: value of any kind that `to_plain` takes.

    Raises:
        OutputError: the folder cannot be made or written to.
    """
    text = json.dumps(to_plain(content), indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    write_file(path, text.encode())


def write_file(path: Path, content: bytes) -> None:
    """Write a file so that it is either whole or not there.

    Args:
        path: path of the file; its folder is made if it does not exist.
        content: bytes of the file.

    Raises:
        OutputError: the folder cannot be made or written to.
    """
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        part.write_bytes(content)
        os.replace(part, path)
    except OSError as error:
        raise OutputError(path, error) from error
    finally:
        with suppress(OSError):  # it is not there, or has no folder
            part.unlink()


def read_json(path: Path) -> Any:
    """The content of a strict JSON file.

    Args:
        path: path of the file.

    Raises:
        InvalidValueError: a file that cannot be read or is not strict JSON; it says why.
    """
    try:
        return json.loads(path.read_bytes(), parse_constant=_refuse_constant)
    except (OSError, ValueError, RecursionError) as error:
        raise InvalidValueError(f"file {str(path)!r}", str(error), "strict JSON") from error


def _refuse_constant(name: str) -> NoReturn:
    raise ValueError(f"{name} is not a number of strict JSON")
