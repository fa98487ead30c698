"""`LostBatch`: what stands in a forked process for a batch whose threads stayed in the parent."""

import ctypes
import os
from collections.abc import Callable
from typing import Any, Protocol
from weakref import WeakSet


class LostBatch:
    """A batch without its threads, whose first call would wait for them for ever.

    The first use of any attribute rebuilds the batch with threads of the forked process.

    Args:
        rebuild: function that returns a batch with the same state.
    """

    def __init__(self, rebuild: Callable[[], Any]) -> None:
        self._rebuild = rebuild

    def __getattr__(self, name: str) -> Any:
        return getattr(self._rebuild(), name)


class Rebuildable(Protocol):
    """Simulations on a batch that can be built anew with the same state."""

    @property
    def batch(self) -> Any:
        """The batch."""

    def use_batch(self, batch: Any) -> None:
        """Use another batch for all calls."""

    def rebuild(self, inherited: Any) -> Any:
        """Build a batch in the state of an inherited one, and use it."""


_WITH_THREADS: WeakSet[Any] = WeakSet()


def rebuild_after_fork(simulation: Rebuildable) -> None:
    """Let a forked process rebuild the batch of some simulations when it first uses them.

    Args:
        simulation: simulations on a batch with threads.
    """
    _WITH_THREADS.add(simulation)


def _leave_threads() -> None:
    """In a forked process: use what was inherited for its state alone."""
    for simulation in list(_WITH_THREADS):
        if not isinstance(simulation.batch, LostBatch):
            _leave_threads_of(simulation)


def _leave_threads_of(simulation: Rebuildable) -> None:
    inherited = simulation.batch
    ctypes.pythonapi.Py_IncRef(ctypes.py_object(inherited))  # the end of the batch would wait for its threads
    simulation.use_batch(LostBatch(lambda: simulation.rebuild(inherited)))


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_leave_threads)
