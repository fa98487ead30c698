"""`Cell`: one entry of a table, as text and as a value."""

import math
from dataclasses import dataclass
from typing import Any, Self

from prp_gym.artifacts import to_plain

_ABSENT = "-"

TONES = ("", "good", "warning", "bad")
"""What a cell's text may stand for; a terminal shows it as a colour, beside the text that says it."""


@dataclass(frozen=True)
class Cell:
    """One entry of a table.

    Attributes:
        text: rounded text that people read.
        value: exact value for programs: text, number, truth value, None for no value, or a tuple with one
            number for each part of the column.
        tone: tone of the text, one of `TONES`; never the only carrier of a meaning.
    """

    text: str
    value: Any
    tone: str = ""

    @classmethod
    def of(cls, value: str | int) -> Self:
        """A text or a whole number, which is shown as it is."""
        return cls(str(value), value)

    @classmethod
    def number(cls, value: float, form: str = ".3f") -> Self:
        """A number in a format specification; a dash for NaN."""
        return cls(_ABSENT if math.isnan(value) else format(value, form), float(value))

    @property
    def plain(self) -> Any:
        """The value in the types of strict JSON; NaN becomes null, infinity the text "inf"."""
        return to_plain(self.value)


ABSENT = Cell(_ABSENT, None)
"""The cell of a value that there is not."""
