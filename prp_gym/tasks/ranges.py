"""Ranges of numbers, from which vectors are drawn for many episodes at once."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from prp_gym.errors import InvalidValueError
from prp_gym.robot.arrays import Array, elementwise


@dataclass(frozen=True)
class Range:
    """A box from which vectors are drawn uniformly; nested lists of a data file are flattened.

    Attributes:
        low: Lower corner of the box.
        high: Upper corner of the box, nowhere below the lower one.
        logarithmic: Whether the logarithms of the values are uniformly distributed, instead of the values.

    Raises:
        InvalidValueError: corners that are not finite, not of one size, or the wrong way round; numbers
            without a logarithm in a logarithmic range.
    """

    low: tuple[float, ...]
    high: tuple[float, ...]
    logarithmic: bool = False

    def __post_init__(self) -> None:
        if len(self.low) != len(self.high):
            raise InvalidValueError("sizes of a range", (len(self.low), len(self.high)), "equal ones")
        for low, high in zip(self.low, self.high, strict=True):
            if not -math.inf < low <= high < math.inf:
                raise InvalidValueError("range", (low, high), "finite numbers, the lower one first")
            if self.logarithmic and low <= 0.0:
                raise InvalidValueError("lower end of a logarithmic range", low, "above 0")

    @classmethod
    def from_table(cls, table: Mapping[str, Any]) -> "Range":
        """Make a range from a table of a data file."""
        low, high = (tuple(np.ravel(table[name]).tolist()) for name in ("low", "high"))
        return cls(low, high, bool(table.get("logarithmic", False)))


class Draws:
    """Draws a vector from each of several ranges, one range after the other.

    Args:
        ranges: Ranges by name, in the order in which they are drawn.
    """

    def __init__(self, ranges: Mapping[str, Range]) -> None:
        ends = np.cumsum([len(box.low) for box in ranges.values()]).tolist()
        self._columns = {
            name: np.s_[:, start:end] for name, start, end in zip(ranges, [0, *ends[:-1]], ends, strict=True)
        }
        low, high = (
            np.array([number for box in ranges.values() for number in getattr(box, corner)])
            for corner in ("low", "high")
        )
        self._logarithmic = [name for name, box in ranges.items() if box.logarithmic]
        for corner in (low, high):
            for name in self._logarithmic:
                part = corner[None][self._columns[name]]
                part[:] = elementwise(math.log, part)
        self._low, self._width = low, high - low

    def draw(self, rngs: Sequence[np.random.Generator]) -> dict[str, Array]:
        """Draw the vectors of n episodes, each with its own generator: arrays (n, size) by name."""
        shares = np.empty((len(rngs), len(self._low)))
        for row, rng in zip(shares, rngs, strict=True):
            rng.random(out=row)
        values = self._low + self._width * shares
        drawn = {name: values[columns] for name, columns in self._columns.items()}
        for name in self._logarithmic:
            drawn[name][:] = elementwise(math.exp, drawn[name])
        return drawn
