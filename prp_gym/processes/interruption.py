"""`Interruption`: a signal that ends a command, and what the command has kept by then."""

import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
"""Signals that end a command in the same way: Ctrl-C, `kill`, and a terminal that was closed."""

_GRACE = 10.0  # s, that the command has to stop its workers and to report what it has kept
_OF_SIGNAL = 128  # added to a signal's number, it is the exit code of a shell's command that the signal ended
_OVER = threading.Event()  # set outside `interruptible`
_OVER.set()
_NOTHING_KEPT = "nothing new had to be kept; give the same command again"


class Interruption(BaseException):
    """A signal that ends the command; like `KeyboardInterrupt`, no handler of exceptions stops it.

    Args:
        signal_number: number of the signal.

    Attributes:
        exit_code: exit code of the command: 130 for SIGINT, 143 for SIGTERM, 129 for SIGHUP.
    """

    def __init__(self, signal_number: int) -> None:
        super().__init__(signal_number)
        self.exit_code = _OF_SIGNAL + signal_number

    @property
    def message(self) -> str:
        """What was kept, and how to go on."""
        return "interrupted: " + "; ".join(getattr(self, "__notes__", None) or [_NOTHING_KEPT]) + "."


@contextmanager
def kept_if_interrupted(describe: Callable[[], str]) -> Iterator[None]:
    """Add to an interruption of the block what was kept and how to go on.

    Args:
        describe: function that returns a sentence without its full stop; an empty one is left out.
    """
    try:
        yield
    except Interruption as interruption:
        if kept := describe():
            interruption.add_note(kept)
        raise


@contextmanager
def interruptible() -> Iterator[None]:
    """Raise `Interruption` in the block at the first signal that asks the process to end.

    A second signal ends the process at once; so does a cleanup that takes longer than 10 s. Signals that the
    process was started to ignore, as by `nohup`, stay ignored. Only the main thread receives signals: in
    another one the block runs unchanged.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = {number: signal.getsignal(number) for number in SIGNALS}
    for number, handler in before.items():
        if handler is not signal.SIG_IGN:
            signal.signal(number, _interrupt)
    _OVER.clear()
    try:
        yield
    finally:
        _OVER.set()
        for number, handler in before.items():
            signal.signal(number, handler)


def relisten() -> None:
    """Install the handlers again that a library has replaced by its own; nothing outside `interruptible`."""
    if not _OVER.is_set() and threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGTERM, _interrupt)


def _interrupt(number: int, _: FrameType | None) -> None:
    for own in SIGNALS:
        signal.signal(own, _end_at_once)
    threading.Thread(target=_end_late, args=(number,), daemon=True).start()
    raise Interruption(number)


def _end_at_once(number: int, _: FrameType | None) -> None:
    os._exit(_OF_SIGNAL + number)


def _end_late(number: int) -> None:
    """End a process whose cleanup hangs; every file of this package is complete at any time."""
    if _OVER.wait(_GRACE):
        return
    _say("interrupted: ended without cleaning up; the next start of the command removes what is left.\n")
    os._exit(_OF_SIGNAL + number)


def _say(text: str) -> None:
    stream: Any = sys.stderr
    try:
        stream.write(text)
        stream.flush()
    except (OSError, ValueError, AttributeError):
        return  # a closed terminal
