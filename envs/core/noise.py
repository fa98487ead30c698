"""White noise for N environments, each with its own generator."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from prp_gym.robot.arrays import Array

_BLOCK = 256  # steps drawn at once for an environment; the numbers of a seed depend on it


class WhiteNoise:
    """White noise: independent standard normal numbers at every step.

    The numbers of an environment depend on its own generator and step count only, not on its neighbours.

    Args:
        num_envs: Number of environments N.
        size: Number of components at every step.
    """

    def __init__(self, num_envs: int, size: int) -> None:
        self._values = np.zeros((_BLOCK, num_envs, size))
        self._steps = np.zeros(num_envs, dtype=np.intp)
        self._rngs = [np.random.default_rng(0) for _ in range(num_envs)]
        self._rows = np.arange(num_envs)

    def begin(self, ids: NDArray[np.intp], rngs: Sequence[np.random.Generator]) -> None:
        """Restart the noise of some environments (n), with their generators."""
        self._steps[ids] = 0
        for index, rng in zip(ids, rngs, strict=True):
            self._rngs[index] = rng
            self._refill(index)

    @property
    def current(self) -> Array:
        """The numbers of this step (N, size)."""
        values: Array = self._values[self._steps % _BLOCK, self._rows]
        return values

    def advance(self) -> None:
        """Go on to the next step."""
        self._steps += 1
        for index in np.flatnonzero(self._steps % _BLOCK == 0):
            self._refill(index)

    def ahead(self, steps: int) -> Array:
        """The numbers (steps, N, size) of this step and of those after it; goes on by as many steps."""
        values = np.empty((steps, *self._values.shape[1:]))
        for row in values:
            row[...] = self.current
            self.advance()
        return values

    def _refill(self, index: np.intp) -> None:
        self._values[:, index] = self._rngs[index].standard_normal(self._values.shape[::2])
