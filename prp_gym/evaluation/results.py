"""Results as JSON: complete, strict and written in one piece."""

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
from typing import Any

import numpy as np

from prp_gym.errors import OutputError
from prp_gym.evaluation.evaluate import Evaluation
from prp_gym.evaluation.metrics import METRICS
from prp_gym.robot.arrays import Array

SCHEMA = 1
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


def to_array(plain: Sequence[Any]) -> Array:
    """Numbers as `to_plain` leaves them, or nested lists of such, as an array again."""
    return np.array(plain, dtype=np.float64)  # numpy reads None as NaN and "inf" as infinity


def list_versions() -> dict[str, str]:
    """Versions of Python and of the packages that a result depends on."""
    return {"python": platform.python_version()} | {name: version(name) for name in _PACKAGES}


def describe_run(command: str) -> dict[str, Any]:
    """What a result depends on beside its settings: versions, machine, command."""
    return {
        "schema": SCHEMA,
        "command": command,
        "versions": list_versions(),
        "machine": {"system": platform.system(), "architecture": platform.machine(), "cores": os.cpu_count()},
        "units": {metric.name: metric.units for metric in METRICS.values()},
    }


def describe_evaluation(evaluation: Evaluation, baseline: str, settings: Any) -> dict[str, Any]:
    """One (environment, scenario, policy) of the results."""
    first = evaluation.rollouts[0]
    return {
        "environment": first.environment_id,
        "scenario": first.scenario,
        "baseline": baseline,
        "settings": settings,
        "control_period": first.period,
        "duration": first.duration,
        "seeds": [rollout.seed for rollout in evaluation.rollouts],
        "score": evaluation.score._asdict(),
        "median": evaluation.median,
        "episodes": evaluation.metrics,
        "compute_time_per_step": evaluation.compute_time,
    }


def prepare_folder(folder: Path) -> None:
    """Make a folder for results, before the work whose results it is to hold.

    Raises:
        OutputError: it cannot be made or written to.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise OutputError(folder, error) from error


def write_json(path: Path, content: Mapping[str, Any]) -> None:
    """Write a JSON file so that it is either whole or not there.

    Args:
        path: of the file; its folder is made if it does not exist.
        content: anything `to_plain` takes.

    Raises:
        OutputError: the folder cannot be made or written to.
    """
    text = json.dumps(to_plain(content), indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    write_file(path, text.encode())


def write_file(path: Path, content: bytes) -> None:
    """Write a file so that it is either whole or not there.

    Args:
        path: of the file; its folder is made if it does not exist.
        content: of the file.

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
