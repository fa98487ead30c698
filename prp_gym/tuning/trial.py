"""A candidate, and what became of it."""

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Trial:
    """A candidate that was played to the end.

    Attributes:
        factors: by the parameters' names.
        score: mean over the episodes [1].
        steps: that it is charged.
        seconds: that it took [s].
    """

    factors: Mapping[str, float]
    score: float
    steps: int
    seconds: float
