"""`Column`: how the median of a metric stands in tables."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Column:
    """How the median of a metric stands in tables.

    Attributes:
        title: above the unit, with line breaks.
        units: of the shown numbers, one a component; of fewer components the first units.
        scale: shown number over the metric's own.
    """

    title: str
    units: tuple[str, ...]
    scale: float = 1.0
