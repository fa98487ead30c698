"""The keywords of vector environments beside those of the single environment."""

import os

from gymnasium.vector import AutoresetMode

from prp_gym.checks import choice, whole

OWN_KEYWORDS = frozenset(("num_threads", "autoreset_mode", "max_episode_steps"))

MOST_ENVIRONMENTS = 100_000
_MOST_THREADS = 1024
_ENVIRONMENTS_PER_THREAD = 4  # with fewer, waking a thread takes longer than it saves


def parse_mode(mode: AutoresetMode | str) -> AutoresetMode:
    """When environments are reset after the end of an episode.

    Raises:
        UnknownNameError: a mode that does not exist.
    """
    if isinstance(mode, AutoresetMode):
        return mode
    return AutoresetMode(choice("autoreset_mode", mode, [known.value for known in AutoresetMode]))


def parse_threads(num_threads: int, num_envs: int) -> int:
    """The number of threads for N environments; 0 takes the cores of this process that save time.

    Raises:
        InvalidValueError: a number that is negative or not whole.
    """
    wanted = whole("num_threads", num_threads, 0, _MOST_THREADS)
    if wanted > 0:
        return wanted
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return max(1, min(cores, num_envs // _ENVIRONMENTS_PER_THREAD))
