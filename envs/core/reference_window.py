"""Episode clocks of N environments, and their references, sampled ahead over a window of periods."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from prp_gym.errors import InvalidValueError
from prp_gym.robot.arrays import Array

_MOST_ROWS = 65536  # of all environments together; bounds the memory
_MOST_STEPS = 512
_FIRST_STEPS = 1  # that are sampled when all environments begin: a reset needs no more

Sampler = Callable[[Array, NDArray[np.intp] | None], Array]
"""Gives the references (..., n, size) at times (..., n) [s] of some environments (n), or of all for None."""


class ReferenceWindow:
    """Counts control periods and gives the reference part of the observations in each.

    Times are whole numbers of periods since the start of each episode, so that what an environment observes
    does not depend on the window or on its neighbours.

    Args:
        num_envs: Number of environments N.
        period: Control period [s].
        horizon: Control periods in an episode, beyond which no reference is sampled ahead.
    """

    def __init__(self, num_envs: int, period: float, horizon: int = _MOST_STEPS) -> None:
        self._period = period
        self._length = int(np.clip(_MOST_ROWS // num_envs, 1, min(_MOST_STEPS, horizon + 1)))
        self._num_envs = num_envs
        self._elapsed = np.zeros(num_envs)  # whole numbers as floats, for fast arithmetic
        self._tick = 0
        self._first = 0
        self._sampled = 0  # periods from the first on
        self._rows = np.zeros((0, num_envs, 0))

    def begin(self, ids: NDArray[np.intp], sampler: Sampler) -> None:
        """Start new episodes in some environments (n); the first call covers all of them."""
        self._elapsed[ids] = 0.0
        if not self.started or len(ids) == self._num_envs:
            self._fill(sampler, _FIRST_STEPS)
            return
        ahead = self._tick - self._first
        times = self._times(self._elapsed[ids], self._sampled - ahead)
        self._rows[ahead : self._sampled, ids] = sampler(times, ids)

    def advance(self, sampler: Sampler) -> None:
        """Go on by one period."""
        self._tick += 1
        self._elapsed += 1.0
        if self._tick - self._first >= self._sampled:
            self._fill(sampler, self._length)

    @property
    def started(self) -> bool:
        """Whether `begin` has been called."""
        return self._rows.size > 0

    @property
    def elapsed(self) -> Array:
        """Whole periods since the start of each episode (N); the array is updated in place."""
        return self._elapsed

    @property
    def current(self) -> Array:
        """The present reference (N, size)."""
        row: Array = self._rows[self._tick - self._first]
        return row

    def hold(self, elapsed: Array, current: Array) -> None:
        """Take over arrays that others keep up to date from now on, in place of `advance`.

        Args:
            elapsed: Whole periods since the start of each episode (N).
            current: Present reference (N, size).
        """
        self._elapsed, self._rows = elapsed, current[None]
        self._first, self._sampled = self._tick, 1

    def times_ahead(self, periods: int) -> Array:
        """Times since the start of each episode (periods, N) in the next periods [s]."""
        times: Array = (np.arange(1, periods + 1)[:, None] + self._elapsed) * self._period
        return times

    def check_times(self, horizon: int) -> None:
        """Refuse times that no episode has.

        Args:
            horizon: Control periods in an episode.

        Raises:
            InvalidValueError: times before the start or after the end of an episode, or between periods; a
                period that was not sampled.
        """
        elapsed, ahead = self._elapsed, self._tick - self._first
        whole = (elapsed >= 0.0) & (elapsed == np.floor(elapsed))
        if not whole.all():
            raise InvalidValueError("elapsed periods", elapsed.tolist(), f"whole numbers, 0 to {horizon}")
        if not 0 <= ahead < self._sampled <= len(self._rows):
            raise InvalidValueError(
                "sampled period", ahead, f"0 to {min(self._sampled, len(self._rows)) - 1}"
            )

    def _fill(self, sampler: Sampler, count: int) -> None:
        """Sample the references of all environments over a number of periods from now on."""
        values = sampler(self._times(self._elapsed, count), None)
        if len(self._rows) < count:  # at first, and after others have kept the present reference
            self._rows = np.zeros((count if self.started else self._length, *values.shape[1:]))
        self._first, self._sampled = self._tick, count
        self._rows[:count] = values

    def _times(self, elapsed: Array, count: int) -> Array:
        """Times [s] of a number of periods from now on (count, n), of which so many (n) have elapsed."""
        times: Array = (np.arange(count)[:, None] + elapsed) * self._period
        return times
