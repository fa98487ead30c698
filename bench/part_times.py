"""`PartTimes`: how long some calls of a program take."""

import time
from collections.abc import Callable, Mapping
from functools import wraps
from typing import Any

Function = Callable[..., Any]


class PartTimes:
    """Times of the parts of a program, each of which is a method of an object.

    Args:
        now: function that returns the time [s]: of a clock, or of the processor.

    Attributes:
        seconds: time of each part so far [s].
    """

    def __init__(self, now: Callable[[], float] = time.perf_counter) -> None:
        self.seconds: dict[str, float] = {}
        self._now = now

    def count(self, part: str, owner: Any, name: str) -> None:
        """Time the calls of a method of an object from now on.

        Args:
            part: name of the part.
            owner: the object.
            name: name of the method.
        """
        setattr(owner, name, self.timed(part, getattr(owner, name)))

    def timed(self, part: str, call: Function) -> Function:
        """A function whose calls are timed."""
        self.seconds[part] = 0.0

        @wraps(call)
        def timed(*arguments: Any, **settings: Any) -> Any:
            start = self._now()
            try:
                return call(*arguments, **settings)
            finally:
                self.seconds[part] += self._now() - start

        return timed

    def restart(self) -> None:
        """Forget the times so far."""
        self.seconds = dict.fromkeys(self.seconds, 0.0)


def shares(seconds: Mapping[str, float], total: float) -> dict[str, float]:
    """Shares of parts in a time; `other` is the rest.

    Args:
        seconds: time of each part [s], none of which contains another one.
        total: time of all [s].
    """
    found = {part: own / total for part, own in seconds.items()}
    return {**found, "other": 1.0 - sum(found.values())}
