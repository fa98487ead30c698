"""The clock that MuJoCo's Python module makes every simulation step read, and how to do without it.

On import the module installs a C callback, `mjcb_time`, which `mj_step` asks for the time about twenty times
a step to fill `MjData.timer`. Nothing is simulated with these times: without the callback a step of the arm
gives the same bits in two thirds of the time. The first world that is built in a process takes the callback
away, for all of that process, unless the environment variable `PRP_GYM_MUJOCO_CLOCK` is set to 1.
"""

import ctypes
import os
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path

import mujoco

KEEP = "PRP_GYM_MUJOCO_CLOCK"
"""Environment variable that keeps MuJoCo's timers where it is 1."""


@cache
def _callback() -> ctypes.c_void_p | None:
    """The place of the callback's address; None where this build of MuJoCo does not show it."""
    mode = getattr(os, "RTLD_NOLOAD", 0) | getattr(os, "RTLD_LAZY", 0)  # the library that runs, or none
    for path in sorted(Path(mujoco.__file__).parent.glob("libmujoco*")):
        try:
            return ctypes.c_void_p.in_dll(ctypes.CDLL(str(path), mode=mode), "mjcb_time")
        except (OSError, ValueError):
            continue
    return None


@cache
def _installed() -> int | None:
    """The address that MuJoCo's module installed; asked for before anything is changed."""
    place = _callback()
    return None if place is None else place.value


def clock_is_read() -> bool:
    """Whether simulation steps of this process read a clock; True where that cannot be known."""
    place = _callback()
    return place is None or place.value is not None


def read_clock(wanted: bool) -> None:
    """Let simulation steps of this process read a clock or not.

    Nothing is done where a user set a clock of their own through `mujoco.set_mjcb_time`, or where this build
    of MuJoCo does not show its callback. A clock installed through ctypes cannot be told from the module's:
    keep it with the environment variable.
    """
    place, installed = _callback(), _installed()
    if place is not None and mujoco.get_mjcb_time() is None:
        place.value = installed if wanted else None


@contextmanager
def clock_reading(wanted: bool) -> Iterator[None]:
    """Let steps read a clock or not within a block, for comparisons; worlds that are built in it obey."""
    stop_clock_once()
    before = clock_is_read()
    read_clock(wanted)
    try:
        yield
    finally:
        read_clock(before)


@cache
def stop_clock_once() -> None:
    """Take the clock away when the first world of a process is built, unless the user wants to keep it."""
    if os.environ.get(KEEP, "") != "1":
        read_clock(False)
