"""The random generators of N environments, each its own."""

from collections.abc import Sequence

import numpy as np
from gymnasium.utils import seeding

from prp_gym.errors import ShapeError

Seeds = int | Sequence[int | None] | None


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
        return tuple(self._seeds[index] for index, _ in enumerate(self.all))

    def own_seeds(self, seed: Seeds) -> list[int | None]:
        """A seed an environment (N): `seed + i` from one number, else as they are given.

        Raises:
            ShapeError: another number of seeds.
        """
        count = len(self._made)
        if seed is None or isinstance(seed, (int, np.integer)):
            return [None if seed is None else int(seed) + index for index in range(count)]
        if len(seed) != count:
            raise ShapeError("seed", (len(seed),), f"one number, or ({count},)")
        return [None if own is None else int(own) for own in seed]
