"""`RealTime`: how many actions are due, and how fast simulated time runs beside real time."""

import time
from collections import deque
from collections.abc import Callable

_LONGEST_GAP = 0.1  # s of real time for which actions are caught up; what lies beyond is lost, and shows
_MEASURED = 2.0  # s of real time over which the factor is measured
_TOLERATED = 0.95  # share of the chosen speed below which the simulation falls behind


class RealTime:
    """Keeps simulated time beside real time, and says where it cannot.

    Args:
        clock: function that returns the real time [s].

    Attributes:
        speed: simulated seconds in a real one, as chosen; 1 is real time.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self.speed = 1.0
        self.start()

    def start(self) -> None:
        """Start to measure anew, for instance after a pause."""
        self._last = self._clock()
        self._owed = 0.0
        self._history: deque[tuple[float, float]] = deque([(self._last, 0.0)])

    def due(self, period: float) -> int:
        """Number of actions that are due.

        Args:
            period: time between actions [s].
        """
        now = self._clock()
        self._owed += self.speed * min(now - self._last, _LONGEST_GAP)
        self._last = now
        count = int(self._owed / period + 1e-9)
        self._owed -= count * period
        return count

    def taken(self, seconds: float) -> None:
        """Take note of simulated time that has gone by [s]."""
        now = self._clock()
        self._history.append((now, self._history[-1][1] + seconds))
        while now - self._history[0][0] > _MEASURED:
            self._history.popleft()

    @property
    def factor(self) -> float:
        """Simulated seconds in a real one, as measured over the last 2 s."""
        (first, start), (last, end) = self._history[0], self._history[-1]
        return (end - start) / (last - first) if last > first else self.speed

    @property
    def falls_behind(self) -> bool:
        """Whether the simulation is slower than the chosen speed."""
        first, last = self._history[0][0], self._history[-1][0]
        return last - first > 0.5 * _MEASURED and self.factor < _TOLERATED * self.speed
