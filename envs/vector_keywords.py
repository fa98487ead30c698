"""The keywords of vector environments beside those of the single environment."""

import os
from collections.abc import Mapping

from gymnasium.vector import AutoresetMode

from prp_gym.checks import choice, whole
from prp_gym.envs.config import RENDER_MODES, EnvConfig, OptionsT, parse_keywords
from prp_gym.errors import InvalidValueError

_OWN_KEYWORDS = frozenset(("num_threads", "autoreset_mode", "max_episode_steps"))

FRAME_MODES = tuple(mode for mode in RENDER_MODES if mode != "human")
"""Render modes of many environments, which have no window."""

MOST_ENVIRONMENTS = 100_000
_MOST_THREADS = 1024
_ENVIRONMENTS_PER_THREAD = 4  # with fewer, waking a thread takes longer than it saves


def parse_config(
    keywords: Mapping[str, object], options: type[OptionsT], max_episode_steps: int | None
) -> tuple[EnvConfig, OptionsT]:
    """The common keywords of N environments, and the task's own ones.

    Args:
        keywords: Keywords of the single environment.
        options: Class of the task's own keywords.
        max_episode_steps: Largest number of steps in an episode; None leaves the `duration` alone.

    Raises:
        PRPError: a keyword that does not exist or a value that is not allowed.
    """
    config, own = parse_keywords(keywords, options, _OWN_KEYWORDS)
    if max_episode_steps is not None:
        config = config.at_most(whole("max_episode_steps", max_episode_steps, 1))
    if config.render_mode == "human":
        allowed = f"{', '.join(FRAME_MODES)} or None"
        raise InvalidValueError("render_mode of many environments", config.render_mode, allowed)
    return config, own


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
