"""Description of the machine on which a benchmark ran."""

import os
import platform
from importlib.metadata import version
from pathlib import Path
from typing import Any

from bench.cores import count_cores
from prp_gym.evaluation.results import describe_run

_CPUS = Path("/proc/cpuinfo")
_LIBRARIES = ("stable_baselines3", "torch", "matplotlib")


def processor() -> str:
    """Name of the processor, as far as the system provides it."""
    if _CPUS.exists():
        for line in _CPUS.read_text(encoding="utf-8", errors="replace").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or "unknown processor"


def describe(command: str) -> dict[str, Any]:
    """Versions, machine and command, with the current load of the machine."""
    about = describe_run(command)
    del about["units"]  # of metrics
    about["versions"] |= {name: version(name) for name in _LIBRARIES}
    load = os.getloadavg() if hasattr(os, "getloadavg") else ()
    about["machine"] |= {"processor": processor(), "cores": count_cores(), "load_average": load}
    return about
