"""`Column`: how the median of a metric stands in tables."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Column:
    """How the median of a metric stands in tables.

    Attributes:
        title: heading above the unit, with soft hyphens where tables may break a word.
        units: units of the shown numbers, one for each component; fewer components have the first units.
        scale: ratio of the shown number to the metric's own value.
    """

    title: str
    units: tuple[str, ...]
    scale: float = 1.0
