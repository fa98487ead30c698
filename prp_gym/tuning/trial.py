"""A candidate, and its score."""

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Trial:
    """A candidate that was evaluated.

    Attributes:
        factors: factors of the search space, by the names of its parameters.
        score: mean score over the episodes [1].
        steps: control steps that the trial uses of the budget.
        seconds: wall time of the trial [s].
    """

    factors: Mapping[str, float]
    score: float
    steps: int
    seconds: float
