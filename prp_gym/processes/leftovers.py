"""Temporary files of the atomic writing: how they are named, and which were left by processes that ended."""

import os
import re
import shutil
import time
from contextlib import suppress
from pathlib import Path

_NAME = re.compile(r"\..+\.(?P<process>\d+)\.part")
_SLACK = 1.0  # s: clocks of files and of processes tick in steps of about 10 ms


def part_of(path: Path) -> Path:
    """Path of the temporary file or folder that this process writes and then renames.

    Args:
        path: path of the complete file or folder.
    """
    return path.with_name(f".{path.name}.{os.getpid()}.part")


def remove_leftovers(folder: Path) -> None:
    """Remove the temporary files and folders of processes that have ended.

    Args:
        folder: folder in which they are; folders in it are left as they are.
    """
    for path in folder.glob(".*.part"):
        if is_left_behind(path):
            remove(path)


def remove(path: Path) -> None:
    """Remove a file or a folder as far as possible; nothing is raised."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path, ignore_errors=True)
    else:
        with suppress(OSError):
            path.unlink()


def is_left_behind(part: Path) -> bool:
    """Whether the process that wrote a temporary file has ended.

    A living process with the same number is another one if it was started after the file was written.
    """
    named = _NAME.fullmatch(part.name)
    if named is None:
        return False
    process = int(named["process"])
    if process == os.getpid():
        return True  # a process calls this before it writes
    try:
        return part.stat().st_mtime + _SLACK < _start_of(process)
    except ProcessLookupError:
        return True
    except OSError:  # the file is gone, or the system does not tell
        return False


def _start_of(process: int) -> float:
    """Time at which a process was started, in seconds since the epoch.

    Raises:
        ProcessLookupError: there is no such process.
        OSError: the system does not tell.
    """
    with suppress(PermissionError):  # it is of another user
        os.kill(process, 0)  # sends no signal, only checks that the process exists
    told = Path(f"/proc/{process}/stat").read_text(encoding="utf-8", errors="replace")
    ticks = float(told.rpartition(")")[2].split()[19]) / os.sysconf("SC_CLK_TCK")
    return time.time() - time.clock_gettime(time.CLOCK_BOOTTIME) + ticks
