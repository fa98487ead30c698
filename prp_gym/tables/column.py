"""`TableColumn`: heading, units and form of a table's column."""

import re
from dataclasses import dataclass

from prp_gym.tables.headings import without_breaks


@dataclass(frozen=True)
class TableColumn:
    """A column of a table.

    Attributes:
        heading: heading that needs no legend, in plain text; its words may be broken at soft hyphens.
        units: units of the numbers, one for each component where they differ; empty for text.
        numeric: whether the cells are numbers, which are aligned to the right.
        parts: names of the components of a cell whose value is a tuple; empty for single values.
        width: number of characters after which a terminal breaks a name in the column; 0 for no limit.
        wraps: whether the column holds sentences, which a terminal wraps into the room that is left.
    """

    heading: str
    units: tuple[str, ...] = ()
    numeric: bool = True
    parts: tuple[str, ...] = ()
    width: int = 0
    wraps: bool = False

    @property
    def title(self) -> str:
        """The heading in one line, without units."""
        return without_breaks(self.heading)

    @property
    def label(self) -> str:
        """The heading in one line with the units."""
        shown = ", ".join(self.shown_units)
        return f"{self.title} [{shown}]" if shown else self.title

    @property
    def shown_units(self) -> tuple[str, ...]:
        """The units, once if all components have the same."""
        return self.units[:1] if len(set(self.units)) == 1 else self.units

    @property
    def key(self) -> str:
        """Name of the column for programs: lower-case letters, digits and underscores."""
        return re.sub(r"\W+", "_", self.title.lower().replace("%", "percent")).strip("_")

    @property
    def fields(self) -> tuple[str, ...]:
        """Labels of the values of a cell, one for each part."""
        if not self.parts:
            return (self.label,)
        units = self.units if len(self.units) == len(self.parts) else self.shown_units * len(self.parts)
        if not units:
            return tuple(f"{self.title} {part}" for part in self.parts)
        return tuple(f"{self.title} {part} [{unit}]" for part, unit in zip(self.parts, units, strict=True))


def text_column(heading: str, width: int = 0) -> TableColumn:
    """A column of names, aligned to the left."""
    return TableColumn(heading, numeric=False, width=width)


def prose_column(heading: str) -> TableColumn:
    """A column of sentences, which a terminal wraps."""
    return TableColumn(heading, numeric=False, wraps=True)


def interval_column(heading: str = "95 % interval", units: tuple[str, ...] = ()) -> TableColumn:
    """A column of intervals, whose values are their two ends."""
    return TableColumn(heading, units, parts=("low", "high"))
