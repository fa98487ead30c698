"""The random generators of N environments."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.utils import seeding
from numpy.typing import NDArray

from prp_gym.checks import random_seed
from prp_gym.errors import ShapeError

Seeds = int | Sequence[int | None] | NDArray[np.integer[Any]] | None


class Generators:
    """One generator for each environment, seeded as Gymnasium seeds that of a single environment.

    A generator without a given seed draws one when it is first used.

    Args:
        num_envs: Number of environments N.
    """

    def __init__(self, num_envs: int) -> None:
        self._made: list[np.random.Generator | None] = [None] * num_envs
        self._seeds: list[int | None] = [None] * num_envs

    def __getitem__(self, index: int) -> np.random.Generator:
        made = self._made[index]
        return self.seed(index, None) if made is None else made

    def seed(self, index: int, seed: int | None) -> np.random.Generator:
        """Make a new generator for one environment; None draws its seed."""
        made, self._seeds[index] = seeding.np_random(seed)
        self._made[index] = made
        return made

    @property
    def all(self) -> tuple[np.random.Generator, ...]:
        """The generators of the environments (N)."""
        return tuple(self[index] for index in range(len(self._made)))

    @property
    def seeds(self) -> tuple[int | None, ...]:
        """The seeds of the generators (N)."""
        return tuple(self.seed_of(index) for index in range(len(self._made)))

    def seed_of(self, index: int) -> int | None:
        """The seed of the generator of one environment."""
        self[index]  # draws a seed if none was given
        return self._seeds[index]

    def own_seeds(self, seed: Seeds) -> list[int | None]:
        """One seed for each environment (N): `seed + i` from one number, otherwise the given ones.

        Raises:
            InvalidValueError: a seed that is not a whole number, or is negative.
            ShapeError: a number of seeds other than N.
        """
        count = len(self._made)
        given = seed.tolist() if isinstance(seed, np.ndarray) else seed
        if given is None:
            return [None] * count
        if isinstance(given, str) or not isinstance(given, Sequence):
            first = random_seed("seed", given)
            return [first + index for index in range(count)]
        if len(given) != count:
            raise ShapeError("seed", (len(given),), f"one number, or ({count},)")
        return [
            None if own is None else random_seed(f"seed of environment {index}", own)
            for index, own in enumerate(given)
        ]
