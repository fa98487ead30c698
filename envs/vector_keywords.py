"""The keywords of many environments beside those of a single one."""

import os

from gymnasium.vector import AutoresetMode

from prp_gym.envs.checks import whole
from prp_gym.errors import UnknownNameError

OWN_KEYWORDS = frozenset(("num_threads", "autoreset_mode", "max_episode_steps"))

_ENVIRONMENTS_A_THREAD = 4  # fewer, and waking a thread costs more than it saves


def parse_mode(mode: AutoresetMode | str) -> AutoresetMode:
    """When an episode that ended begins anew.

    Raises:
        UnknownNameError: no such mode.
    """
    try:
        return AutoresetMode(mode)
    except ValueError:
        raise UnknownNameError("autoreset_mode", mode, [known.value for known in AutoresetMode]) from None


def parse_threads(num_threads: int, num_envs: int) -> int:
    """How many threads step so many environments; 0 takes all cores of this process that pay.

    Raises:
        InvalidValueError: not a whole number, or negative.
    """
    wanted = whole("num_threads", num_threads, 0)
    if wanted > 0:
        return wanted
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return max(1, min(cores, num_envs // _ENVIRONMENTS_A_THREAD))
