"""The clock that MuJoCo's Python module makes every simulation step read, and how to turn it off.

On import the module installs a C callback, `mjcb_time`, which `mj_step` calls about twenty times per
step to fill `MjData.timer`. The simulation does not use these times: without the callback a step of the arm
gives the same bits in two thirds of the time. The first world that is built in a process removes the callback
for the whole process, unless the environment variable `PRP_GYM_MUJOCO_CLOCK` is set to 1.
"""

import ctypes
import os
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path

import mujoco

KEEP = "PRP_GYM_MUJOCO_CLOCK"
"""Environment variable that keeps MuJoCo's timers if it is 1."""


@cache
def _callback() -> ctypes.c_void_p | None:
    """Pointer to the callback's address; None if this build of MuJoCo does not export it."""
    mode = getattr(os, "RTLD_NOLOAD", 0) | getattr(os, "RTLD_LAZY", 0)  # only if it is loaded already
    for path in sorted(Path(mujoco.__file__).parent.glob("libmujoco*")):
        try:
            return ctypes.c_void_p.in_dll(ctypes.CDLL(str(path), mode=mode), "mjcb_time")
        except (OSError, ValueError):
            continue
    return None


@cache
def _installed() -> int | None:
    """Address that MuJoCo's module installed; it is read before anything is changed."""
    pointer = _callback()
    return None if pointer is None else pointer.value


def clock_is_read() -> bool:
    """Whether simulation steps of this process read a clock; True if that cannot be determined."""
    pointer = _callback()
    return pointer is None or pointer.value is not None


def read_clock(wanted: bool) -> None:
    """Let simulation steps of this process read a clock or not.

    It has no effect if the user set a clock through `mujoco.set_mjcb_time`, or if this build of MuJoCo does
    not export its callback. A clock installed through ctypes cannot be distinguished from the module's; keep
    it with the environment variable.
    """
    pointer, installed = _callback(), _installed()
    if pointer is not None and mujoco.get_mjcb_time() is None:
        pointer.value = installed if wanted else None


@contextmanager
def clock_reading(wanted: bool) -> Iterator[None]:
    """Let simulation steps read a clock or not within a `with` block, also in worlds that are built in it."""
    stop_clock_once()
    before = clock_is_read()
    read_clock(wanted)
    try:
        yield
    finally:
        read_clock(before)


@cache
def stop_clock_once() -> None:
    """Remove the clock when the first world of a process is built, unless the user wants to keep it."""
    if os.environ.get(KEEP, "") != "1":
        read_clock(False)
