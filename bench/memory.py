"""Memory that each environment of a vector environment takes, from processes that hold nothing else."""

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import gymnasium

from bench.rounds import CONTACT, FREE, Effort

_STEPS = 3
_STATUS = Path("/proc/self/statm")


def resident_bytes() -> int:
    """Memory of this process that is in use; 0 where the system does not say."""
    if not _STATUS.exists():
        return 0
    return int(_STATUS.read_text(encoding="ascii").split()[1]) * os.sysconf("SC_PAGE_SIZE")


def measure(effort: Effort) -> list[dict[str, Any]]:
    """Bytes an environment: what N of them take beyond a single one, over N - 1."""
    rows = []
    for environment in (FREE, CONTACT):
        least = _in_process(environment, 1)
        for count in sorted(effort.sizes)[-2:]:
            if count > 1:
                each = (_in_process(environment, count) - least) / (count - 1)
                rows.append({"environment": environment, "num_envs": count, "bytes_per_env": each})
    return rows


def _in_process(environment: str, count: int) -> int:
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
