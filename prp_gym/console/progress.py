"""`Progress`: how a command tells how far its work is."""

import math
from collections.abc import Sequence
from typing import Protocol

from prp_gym.console.activity import Activity

_MINUTE, _HOUR = 60, 3600  # s


class Progress(Protocol):
    """How far the work of a command is; entered before the work begins."""

    def __enter__(self) -> "Progress":
        """Begin to tell the progress."""

    def __exit__(self, *_: object) -> None:
        """Tell nothing any more."""

    def begin(self, done: float) -> None:
        """Set the work that an interrupted run has done before.

        Args:
            done: amount of work, in the unit of the total.
        """

    def advance(self, amount: float) -> None:
        """Add to the work that is done.

        Args:
            amount: amount of work, in the unit of the total.
        """

    def reach(self, done: float) -> None:
        """Set the work that is done.

        Args:
            done: amount of work, in the unit of the total.
        """

    def run(self, activities: Sequence[Activity]) -> None:
        """Set what is being worked on.

        Args:
            activities: work that is under way.
        """


def time_left(elapsed: float, done: float, before: float, total: float) -> float:
    """Time until the work is done, if it goes on as fast as until now [s]; NaN if that is not known yet.

    Args:
        elapsed: time since the work began [s].
        done: amount of work that is done.
        before: amount of work that was done before it began, by an interrupted run.
        total: amount of work.
    """
    if done <= before or not math.isfinite(total):
        return math.nan
    return elapsed * max(total - done, 0.0) / (done - before)


def duration(seconds: float) -> str:
    """A time in words of two units at most.

    Args:
        seconds: time [s].
    """
    whole = round(seconds)
    if whole < _MINUTE:
        return f"{whole} s"
    if whole < _HOUR:
        return f"{whole // _MINUTE} min {whole % _MINUTE} s"
    return f"{whole // _HOUR} h {whole % _HOUR // _MINUTE} min"
