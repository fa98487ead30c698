"""Worker processes that end with the process that started them, however that one ends."""

import os
import select
import signal
import threading
import time

_EVERY = 0.1  # s, between two looks at the parent where the system cannot report its end


def end_with_parent(parent: int) -> None:
    """End this process as soon as its parent has ended, also one that was killed.

    A thread waits for the parent's end. The kernel's own signal of a parent's end (`PR_SET_PDEATHSIG`) is no
    substitute: it comes as soon as the thread that has started this process ends. SIGINT, which a terminal
    sends to all processes, is left to the parent, which stops its workers.

    Args:
        parent: process id of the parent, from the parent itself.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_wait, args=(parent,), name="parent", daemon=True).start()


def _wait(parent: int) -> None:
    """Wait for the end of the parent, then end this process without any cleanup."""
    try:
        descriptor = os.pidfd_open(parent)
    except (AttributeError, OSError):  # no Linux, an old one, or a parent that has ended
        pass
    else:
        if os.getppid() == parent:  # and not another process with the same number
            select.select([descriptor], [], [])
    while os.getppid() == parent:
        time.sleep(_EVERY)
    os._exit(1)
