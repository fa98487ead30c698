"""Memory that each environment of a vector environment takes, from processes that hold nothing else."""

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
    """Memory of this process that is in use; 0 where the system does not say."""
    if not _STATUS.exists():
        return 0
    return int(_STATUS.read_text(encoding="ascii").split()[1]) * os.sysconf("SC_PAGE_SIZE")


def measure(effort: Effort) -> list[dict[str, Any]]:
    """Bytes an environment: what N of them take beyond a single one, over N - 1."""
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
    """One and every size in free space; in contact, where preparing takes long, only some of them."""
    chosen = set(effort.sizes) & set(_SIZES.get(environment, effort.sizes))
    return sorted({1, *chosen})


def _in_process(place: tuple[str, int]) -> int:
    environment, count = place
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
