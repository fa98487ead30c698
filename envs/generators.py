"""The random generators of N environments, each its own."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.utils import seeding
from numpy.typing import NDArray

from prp_gym.envs.checks import whole
from prp_gym.errors import ShapeError

Seeds = int | Sequence[int | None] | NDArray[np.integer[Any]] | None


class Generators:
    """One generator an environment, seeded as Gymnasium seeds that of a single one.

    A generator that was given no seed draws one when it is first asked for.

    Args:
        num_envs: N.
    """

    def __init__(self, num_envs: int) -> None:
        self._made: list[np.random.Generator | None] = [None] * num_envs
        self._seeds: list[int | None] = [None] * num_envs

    def __getitem__(self, index: int) -> np.random.Generator:
        made = self._made[index]
        return self.seed(index, None) if made is None else made

    def seed(self, index: int, seed: int | None) -> np.random.Generator:
        """A new generator for one environment; None draws its seed."""
        made, self._seeds[index] = seeding.np_random(seed)
        self._made[index] = made
        return made

    @property
    def all(self) -> tuple[np.random.Generator, ...]:
        """The generators (N)."""
        return tuple(self[index] for index in range(len(self._made)))

    @property
    def seeds(self) -> tuple[int | None, ...]:
        """Their seeds (N)."""
        return tuple(self.seed_of(index) for index in range(len(self._made)))

    def seed_of(self, index: int) -> int | None:
        """The seed of one generator."""
        self[index]  # draws one where none was given
        return self._seeds[index]

    def own_seeds(self, seed: Seeds) -> list[int | None]:
        """A seed an environment (N): `seed + i` from one number, else as they are given.

        Raises:
            InvalidValueError: a seed that is no whole number, or negative.
            ShapeError: another number of seeds.
        """
        count = len(self._made)
        given = seed.tolist() if isinstance(seed, np.ndarray) else seed
        if given is None:
            return [None] * count
        if isinstance(given, str) or not isinstance(given, Sequence):
            first = whole("seed", given, 0)
            return [first + index for index in range(count)]
        if len(given) != count:
            raise ShapeError("seed", (len(given),), f"one number, or ({count},)")
        return [
            None if own is None else whole(f"seed of environment {index}", own, 0)
            for index, own in enumerate(given)
        ]
