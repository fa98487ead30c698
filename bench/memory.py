"""Memory of each environment of a vector environment, measured in processes of its own."""

import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import gymnasium

from bench.cores import count_cores
from bench.rounds import CONTACT, FREE, Effort

_STEPS = 3
_SIZES = {CONTACT: (64, 1024)}
_STATUS = Path("/proc/self/statm")


def resident_bytes() -> int:
    """Memory that this process uses; 0 if the system does not provide it."""
    if not _STATUS.exists():
        return 0
    return int(_STATUS.read_text(encoding="ascii").split()[1]) * os.sysconf("SC_PAGE_SIZE")


def measure(effort: Effort) -> list[dict[str, Any]]:
    """Bytes per environment: the memory of N environments beyond that of a single one, divided by N - 1."""
    conditions = [
        (environment, count) for environment in (FREE, CONTACT) for count in _counts(environment, effort)
    ]
    with ThreadPoolExecutor(count_cores()) as pool:
        taken = dict(zip(conditions, pool.map(_in_process, conditions), strict=True))
    return [
        {
            "environment": environment,
            "num_envs": count,
            "bytes_per_env": (taken[environment, count] - taken[environment, 1]) / (count - 1),
        }
        for environment, count in conditions
        if count > 1
    ]


def _counts(environment: str, effort: Effort) -> list[int]:
    """One and all sizes in free space; only some of them in contact, where preparation takes long."""
    chosen = set(effort.sizes) & set(_SIZES.get(environment, effort.sizes))
    return sorted({1, *chosen})


def _in_process(condition: tuple[str, int]) -> int:
    environment, count = condition
    command = [sys.executable, "-m", "bench.memory", environment, str(count)]
    return int(subprocess.run(command, check=True, capture_output=True, text=True).stdout.split()[-1])


def main() -> None:
    """`python -m bench.memory ID N`: make, reset and step N environments, and print the bytes in use."""
    environment, count = sys.argv[1], int(sys.argv[2])
    env = gymnasium.make_vec(environment, num_envs=count)
    env.reset(seed=0)
    for _ in range(_STEPS):
        env.step(env.action_space.sample())
    print(resident_bytes())


if __name__ == "__main__":
    main()
