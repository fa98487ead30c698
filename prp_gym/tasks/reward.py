"""The one bounded reward shape that every task uses."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from prp_gym.errors import InvalidValueError
from prp_gym.robot.arrays import Array


@dataclass(frozen=True)
class RewardTerm:
    """One term w κ(‖e/s‖).

    Attributes:
        name: as it appears in `info`, there with the prefix `reward_`.
        weight: w, the term's share of the score.
        scale: s, the error in one component that alone halves the term's worth.
        unit: of each component.
    """

    name: str
    weight: float
    scale: tuple[float, ...]
    unit: tuple[str, ...]

    @classmethod
    def from_table(cls, name: str, table: Mapping[str, Any]) -> "RewardTerm":
        """A term as it stands in a data file."""
        return cls(name, float(table["weight"]), tuple(map(float, table["scale"])), tuple(table["unit"]))


class Reward:
    """dt Σ w_i κ(‖e_i/s_i‖): an episode's return lies in [0, duration] whatever the control rate.

    κ(z) = 1/(1 + z): 1 without error, ½ at an error of one scale, and never flat.

    Args:
        terms: with weights that sum to 1.
        period: dt, the control period [s].

    Raises:
        InvalidValueError: weights that are negative or do not sum to 1, a scale that is not positive.
    """

    def __init__(self, terms: Sequence[RewardTerm], period: float) -> None:
        total = math.fsum(term.weight for term in terms)
        if not math.isclose(total, 1.0, abs_tol=1e-9):
            raise InvalidValueError("sum of the reward weights", total, "1")
        for term in terms:
            if not term.weight >= 0.0:
                raise InvalidValueError(f"weight of reward term {term.name!r}", term.weight, "at least 0")
            if not all(value > 0.0 for value in term.scale):
                raise InvalidValueError(f"scale of reward term {term.name!r}", term.scale, "above 0")
        self.terms = tuple(terms)
        self._worth = np.array([term.weight * period for term in terms])
        width = max(len(term.scale) for term in terms)
        self._per_scale = np.zeros((len(terms), width))
        for row, term in zip(self._per_scale, terms, strict=True):
            row[: len(term.scale)] = 1.0 / np.array(term.scale)
        self._shape_up((1, len(terms), width))

    def _shape_up(self, shape: tuple[int, ...]) -> None:
        """Bring the numbers to the shape of errors: on small arrays broadcasting costs more than sums do."""
        self._shape = shape
        self._factor = np.broadcast_to(self._per_scale, shape).copy()
        self._numerator = np.broadcast_to(self._worth, shape[:-1]).copy()
        self._one = np.ones(shape[:-1])

    def __call__(self, errors: Array) -> Array:
        """What each term contributes to a step's reward.

        Args:
            errors: (..., terms, width) in the terms' units, width that of the longest scale; what a
                shorter term leaves over does not count.

        Returns:
            (..., terms) [s]; their sum is the reward.
        """
        if errors.shape != self._shape:
            self._shape_up(errors.shape)
        scaled = errors * self._factor
        denominator: Array = np.sqrt(np.vecdot(scaled, scaled))
        denominator += self._one
        contributions: Array = np.divide(self._numerator, denominator, out=denominator)
        return contributions
