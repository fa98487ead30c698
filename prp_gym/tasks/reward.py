"""The one bounded reward shape that every task uses."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from prp_gym.errors import InvalidValueError
from prp_gym.robot.arrays import Array, norm, sum_of_products


@dataclass(frozen=True)
class RewardTerm:
    """One reward term w κ(‖e/s‖).

    Attributes:
        name: Name of the term; `info` has it with the prefix `reward_`.
        weight: Weight w, the largest share of the term in the score.
        scale: Scale s of each component: an error of one scale in a single component halves the term.
        unit: Unit of each component.
    """

    name: str
    weight: float
    scale: tuple[float, ...]
    unit: tuple[str, ...]

    @classmethod
    def from_table(cls, name: str, table: Mapping[str, Any]) -> "RewardTerm":
        """Make a term from a table of a data file."""
        return cls(name, float(table["weight"]), tuple(map(float, table["scale"])), tuple(table["unit"]))


class Reward:
    """Σ w_i κ(‖e_i/s_i‖), in [0, 1] at every step.

    κ(z) = 1/(1 + z): 1 without error, ½ at an error of one scale, with a nonzero slope everywhere.

    Args:
        terms: Reward terms, whose weights sum to 1.

    Raises:
        InvalidValueError: weights that are negative or do not sum to 1, a scale that is not positive.
    """

    def __init__(self, terms: Sequence[RewardTerm]) -> None:
        total = math.fsum(term.weight for term in terms)
        if not math.isclose(total, 1.0, abs_tol=1e-9):
            raise InvalidValueError("sum of the reward weights", total, "1")
        for term in terms:
            if not term.weight >= 0.0:
                raise InvalidValueError(f"weight of reward term {term.name!r}", term.weight, "at least 0")
            if not all(value > 0.0 for value in term.scale):
                raise InvalidValueError(f"scale of reward term {term.name!r}", term.scale, "above 0")
        self.terms = tuple(terms)
        self._shares = [term.weight for term in terms]
        self._largest = np.array(self._shares)
        width = max(len(term.scale) for term in terms)
        self._per_scale = np.zeros((len(terms), width))
        for row, term in zip(self._per_scale, terms, strict=True):
            row[: len(term.scale)] = 1.0 / np.array(term.scale)
        self._expand((1, len(terms), width))

    def _expand(self, shape: tuple[int, ...]) -> None:
        """Expand weights and scales to the shape of the errors once: broadcasting small arrays is slow."""
        self._shape = shape
        self._factor = np.broadcast_to(self._per_scale, shape).copy()
        self._numerator = np.broadcast_to(self._largest, shape[:-1]).copy()
        self._one = np.ones(shape[:-1])

    def __call__(self, errors: Array) -> Array:
        """The contribution of each term to the reward of a step.

        Args:
            errors: Errors in the units of the terms (..., terms, width), where width is that of the longest
                scale; further components of shorter terms do not count.

        Returns:
            Contributions (..., terms), whose sum is the reward.
        """
        if errors.shape != self._shape:
            self._expand(errors.shape)
        scaled = errors * self._factor
        is_one = scaled.ndim == 3 and len(scaled) == 1 and type(scaled) is np.ndarray
        if is_one:  # numbers are faster than small arrays, with the same bits
            rows = zip(self._shares, *scaled.tolist(), strict=True)
            return np.array([[w / (math.sqrt(sum_of_products(z, z)) + 1.0) for w, z in rows]])
        denominator = norm(scaled)
        denominator += self._one
        contributions: Array = np.divide(self._numerator, denominator, out=denominator)
        return contributions
