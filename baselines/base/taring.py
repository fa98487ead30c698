"""Taring of the force sensor: the mean of its readings off the surface is subtracted from every reading."""

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from prp_gym.robot.arrays import Array, dot, norm

Memory = tuple[Array, ...]

_TARE, _COUNT, _SUM, _NEW = slice(0, 3), slice(3, 4), slice(4, 7), slice(7, 8)
_EXCESS, _TOUCH, _POINT = slice(8, 9), slice(9, 10), slice(10, 13)
_COUNTED = slice(0, 4)  # the tare with its count
_LATER, _EARLIER, _AGE = slice(13, 17), slice(17, 21), slice(21, 22)  # former tares with their counts
_PRESS, _PRESSED = slice(22, 25), slice(25, 26)  # sum and number of the clear forces since the touch
_SIZE = 26


class Taring(ABC):
    """How the readings of a force sensor are corrected; its memory is a tuple of arrays (..., any size).

    Attributes:
        arrays: number of arrays of the memory.
    """

    arrays: ClassVar[int]

    @abstractmethod
    def begin(self, shape: tuple[int, ...]) -> Memory:
        """The memory at the start of an episode, for leading dimensions `shape`."""

    @abstractmethod
    def step(self, memory: Memory, reading: Array, tip: Array) -> tuple[Array, Memory]:
        """One control period.

        Args:
            memory: arrays from `begin` or from the last call.
            reading: force (..., 3) by the tip on the surface as the sensor reads it, world frame [N].
            tip: position of the tip (..., 3) in the world frame [m].

        Returns:
            the corrected force (..., 3) [N], and the memory a period later.
        """


class NoTaring(Taring):
    """The reading as it is."""

    arrays = 0

    def begin(self, shape: tuple[int, ...]) -> Memory:
        """See `Taring.begin`: there is no memory."""
        return ()

    def step(self, memory: Memory, reading: Array, tip: Array) -> tuple[Array, Memory]:
        """See `Taring.step`."""
        return reading, memory


@dataclass(frozen=True)
class TaringUntilContact(Taring):
    """The mean of all readings b̂ before the first touch is subtracted: f = reading - b̂.

    The touch is a change of the readings' mean, found by a cumulative sum s ← max(0, s + |f| - 2.8 σ) with
    the sensor's noise σ on each axis: it is seen when s exceeds 4 σ. Noise alone has |f| = 1.6 σ on average,
    so that s returns to 0 every few periods, and exceeds 4 σ about once in 10⁸ of them; a force of 7 σ is
    seen at once, a lasting force above 2.3 σ within some periods. Readings count for b̂ only once s is 0
    again after them, and at the touch b̂ goes back to what it was some readings before, if there were so many:
    what a slowly growing contact force adds, until it is seen, is dropped.

    The error of b̂ is common to all readings, and large after few of them: before as many have been counted as
    are held back, three standard errors of b̂, 3 σ count^-½, are subtracted from |f| too.

    A first reading above the largest bias is a touch, and nothing is subtracted. A contact force that acts
    from the first reading on and is below that cannot be told from a bias, and is subtracted.

    Attributes:
        noise: standard deviation σ of the sensor's noise on each axis, above 0 [N].
        largest_bias: largest magnitude of the sensor's bias [N].
        largest_count: number of readings from which b̂ forgets: later ones weigh as much as this number would
            give them. Infinite for a bias that stays.
        held_back: number of readings before the touch that are dropped; up to twice as many are.

    Source: Page 1954, the cumulative sum test.
    """

    noise: float
    largest_bias: float
    largest_count: float = math.inf
    held_back: float = 15.0

    arrays: ClassVar[int] = 1
    allowance: ClassVar[float] = 2.8
    decision: ClassVar[float] = 4.0
    certainty: ClassVar[float] = 3.0

    def begin(self, shape: tuple[int, ...]) -> Memory:
        """See `Taring.begin`: no reading, no touch."""
        return (np.zeros((*shape, _SIZE)),)

    def step(self, memory: Memory, reading: Array, tip: Array) -> tuple[Array, Memory]:
        """See `Taring.step`."""
        after = self._released(memory[0], reading, tip)
        count, touched = after[..., _COUNT], after[..., _TOUCH] > 0.0
        first = (count == 0.0) & ~touched & (norm(reading)[..., None] <= self.largest_bias)
        force = np.where(first, 0.0, reading - after[..., _TARE])
        size = norm(force)[..., None]
        spread = self.noise * np.sqrt(1.0 + 1.0 / np.maximum(count, 1.0))
        common = np.where(count < self.held_back, self.certainty / np.sqrt(np.maximum(count, 1.0)), 0.0)
        excess = np.maximum(0.0, after[..., _EXCESS] + size - self.allowance * spread - common * self.noise)
        seen = ~touched & ((excess > self.decision * spread) | ((count == 0.0) & ~first))
        touched |= seen
        self._learn(after, reading, excess, touched)
        self._go_back(after, seen)
        after[..., _TOUCH] = touched
        after[..., _POINT] = np.where(seen, tip, after[..., _POINT])
        clear = touched & (seen | (size > self.allowance * spread))
        after[..., _PRESS] = np.where(clear, after[..., _PRESS] + force, after[..., _PRESS])
        after[..., _PRESSED] = np.where(clear, after[..., _PRESSED] + 1.0, after[..., _PRESSED])
        return force, (after,)

    def _released(self, memory: Array, reading: Array, tip: Array) -> Array:
        """A copy of the memory, in which contact may have ended; here it never does."""
        return memory.copy()

    def _learn(self, after: Array, reading: Array, excess: Array, touched: NDArray[np.bool_]) -> None:
        """Count the reading, and take all that are counted into b̂ where s is 0; in place."""
        total, new = after[..., _SUM] + reading, after[..., _NEW] + 1.0
        count = after[..., _COUNT]
        accepted = (excess == 0.0) & ~touched
        mean = (after[..., _TARE] * count + total) / (count + new)
        after[..., _TARE] = np.where(accepted, mean, after[..., _TARE])
        after[..., _COUNT] = np.where(accepted, np.minimum(count + new, self.largest_count), count)
        after[..., _SUM] = np.where(accepted | touched, 0.0, total)
        after[..., _NEW] = np.where(accepted | touched, 0.0, new)
        after[..., _EXCESS] = np.where(touched, 0.0, excess)

    def _go_back(self, after: Array, seen: NDArray[np.bool_]) -> None:
        """Restore the former b̂ at the touch, and keep the present one from time to time; in place."""
        former = seen & (after[..., _EARLIER][..., 3:] > 0.0)
        after[..., _COUNTED] = np.where(former, after[..., _EARLIER], after[..., _COUNTED])
        after[..., _AGE] += 1.0
        due = after[..., _AGE] >= self.held_back
        after[..., _EARLIER] = np.where(due, after[..., _LATER], after[..., _EARLIER])
        after[..., _LATER] = np.where(due, after[..., _COUNTED], after[..., _LATER])
        after[..., _AGE] = np.where(due, 0.0, after[..., _AGE])


@dataclass(frozen=True)
class TaringWheneverFree(TaringUntilContact):
    """As `TaringUntilContact`, and anew once the tip has left the surface: for a bias that drifts.

    At the touch the tip is at most F/K_min deep, with the force F = 6.8 σ that is seen at once and the least
    stiffness K_min of a surface at rest. When it has withdrawn by more than that from the point of the touch,
    against the direction of the force, it is off the surface whatever the force reads, so that a contact
    force, however small, is never subtracted. The direction is that of the sum of all clear forces since the
    touch; its angle is uncertain by three standard errors of their mean, and the withdrawal counts along that
    direction within this angle for which it is smallest: a tip that slides along the surface does not seem to
    leave it. As a second condition, for a surface that follows the tip, the change of the reading since then
    must be within the largest bias.

    Attributes:
        least_stiffness: least stiffness K_min of a surface, above 0 [N/m].
    """

    least_stiffness: float = 50.0

    def _released(self, memory: Array, reading: Array, tip: Array) -> Array:
        """A copy of the memory, empty where the tip has left the surface."""
        clearance = (self.allowance + self.decision) * self.noise / self.least_stiffness
        small = norm(reading) <= self.largest_bias
        free = (memory[..., _TOUCH][..., 0] > 0.0) & (self._withdrawn(memory, tip) > clearance) & small
        return np.where(free[..., None], 0.0, memory)

    def _withdrawn(self, memory: Array, tip: Array) -> Array:
        """The least distance (...) by which the tip has withdrawn since the touch [m]."""
        moved, press = memory[..., _POINT] - tip, memory[..., _PRESS]
        size = np.maximum(norm(press), 1e-12)
        along = dot(press / size[..., None], moved)
        across = np.sqrt(np.maximum(dot(moved, moved) - along**2, 0.0))
        pressed, count = memory[..., _PRESSED][..., 0], np.maximum(memory[..., _COUNT][..., 0], 1.0)
        error = self.noise * np.sqrt(pressed + pressed**2 / count)  # of the sum; the tare has one of its own
        sine = np.minimum(self.certainty * error / size, 1.0)
        withdrawn: Array = along * np.sqrt(1.0 - sine**2) - across * sine
        return withdrawn
