"""Building the libraries of all code that some tasks need, in a folder from which a wheel takes them."""

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

from prp_gym.artifacts import prepare_folder
from prp_gym.prebuilding.short_episodes import run_short_episodes
from prp_gym.symbolic.compiler import build_library, loaded_sources

Conditions = Iterable[tuple[str, str]]
"""Ids of environments and scenarios."""


def build_libraries(
    conditions: Conditions, folder: Path, report: Callable[[str], None] = lambda _: None
) -> list[Path]:
    """Build a library of every C source that this process has loaded after short episodes.

    Args:
        conditions: ids of environments and scenarios.
        folder: folder of the libraries, which is made.
        report: takes a line about the progress.

    Returns:
        paths of the libraries.

    Raises:
        CompilerError: no compiler, or one that does not work.
        GeneratedCodeError: generated code that the compiler rejects.
        OutputError: the folder cannot be made.
    """
    prepare_folder(folder)
    for environment_id, scenario in conditions:
        run_short_episodes(environment_id, scenario)
        report(f"{environment_id}, scenario {scenario}: {len(loaded_sources())} sources in all")
    with ThreadPoolExecutor(os.cpu_count()) as threads:  # each waits for a compiler
        return list(threads.map(partial(build_library, folder=folder), loaded_sources()))
