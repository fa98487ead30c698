"""`Lines`: progress where there is no terminal, as a plain line now and then."""

import math
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import suppress

from prp_gym.console.activity import Activity
from prp_gym.console.progress import duration, time_left

PERIOD = 25.0
"""Time between two lines [s], below the 30 s that no command is silent for."""

_MOST_NAMES = 3  # in a line


class Lines:
    """A line with what is done, what is under way and how long it will take, as long as the work lasts.

    A thread writes the lines, so that one comes also while a single long piece of work is under way. Work
    that is shorter than the time between two lines has none.

    Args:
        write: function that writes a line.
        label: what is done, such as "evaluating".
        total: amount of work in `unit`; infinite if it is not known.
        unit: unit of the amount, such as "episodes".
        done: amount that an interrupted run has done before.
        clock: clock [s].
    """

    def __init__(
        self,
        write: Callable[[str], object],
        label: str,
        total: float = math.inf,
        unit: str = "",
        done: float = 0.0,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._write, self._label, self._total, self._unit = write, label, total, unit
        self._before = self._done = done
        self._clock, self._start = clock, clock()
        self._activities: tuple[Activity, ...] = ()
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._beat, name="progress", daemon=True)

    def __enter__(self) -> "Lines":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._thread.join()

    def begin(self, done: float) -> None:
        """See `Progress.begin`."""
        self._before = self._done = done
        self._start = self._clock()

    def advance(self, amount: float) -> None:
        """See `Progress.advance`."""
        self._done += amount

    def reach(self, done: float) -> None:
        """See `Progress.reach`."""
        self._done = done

    def run(self, activities: Sequence[Activity]) -> None:
        """See `Progress.run`."""
        self._activities = tuple(activities)

    @property
    def line(self) -> str:
        """The line that describes the present state."""
        elapsed = self._clock() - self._start
        parts = [f"{duration(elapsed)} elapsed"]
        if math.isfinite(self._total):
            share = 100 * self._done / self._total if self._total else 100.0
            parts.insert(0, f"{self._done:,.0f} of {self._total:,.0f} {self._unit} ({share:.0f} %)")
        left = time_left(elapsed, self._done, self._before, self._total)
        if left > 0.0:
            parts.append(f"about {duration(left)} left")
        return f"{self._label}: {', '.join(parts)}{self._running()}"

    def _running(self) -> str:
        if not self._activities:
            return ""
        names = [item.text for item in self._activities[:_MOST_NAMES]]
        more = len(self._activities) - len(names)
        return f"; running: {', '.join(names)}{f' and {more} more' if more else ''}"

    def _beat(self) -> None:
        while not self._over.wait(PERIOD):
            with suppress(OSError, ValueError):  # of a stream that was closed
                self._write(self.line)
