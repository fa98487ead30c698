"""White noise for N environments, each with its own generator."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from prp_gym.robot.arrays import Array

_BLOCK = 256  # steps whose numbers are drawn at once for an environment
_FIRST = 8  # steps whose numbers are drawn when an episode begins: many episodes end before a block does


class WhiteNoise:
    """White noise: independent standard normal numbers at every step.

    The numbers of an environment depend on its own generator and step count only, not on its neighbours.

    Args:
        num_envs: Number of environments N.
        size: Number of components at every step.
    """

    def __init__(self, num_envs: int, size: int) -> None:
        self._values = np.zeros((num_envs, _BLOCK, size))
        self._steps = np.zeros(num_envs, dtype=np.intp)
        self._drawn = np.zeros(num_envs, dtype=np.intp)  # steps up to which the numbers are drawn
        self._rngs = [np.random.default_rng(0) for _ in range(num_envs)]
        self._rows = np.arange(num_envs)

    def begin(self, ids: NDArray[np.intp], rngs: Sequence[np.random.Generator]) -> None:
        """Restart the noise of some environments (n), with their generators."""
        self._steps[ids], self._drawn[ids] = 0, _FIRST
        for index, rng in zip(ids.tolist(), rngs, strict=True):
            self._rngs[index] = rng
            rng.standard_normal(out=self._values[index, :_FIRST])

    @property
    def current(self) -> Array:
        """The numbers of this step (N, size)."""
        values: Array = self._values[self._rows, self._steps % _BLOCK]
        return values

    def advance(self) -> None:
        """Go on to the next step."""
        self._steps += 1
        for index in np.flatnonzero(self._steps == self._drawn).tolist():
            self._draw_to_end_of_block(index)

    def _draw_to_end_of_block(self, index: int) -> None:
        """Draw the numbers of one environment from its present step to the end of the block."""
        start = self._steps[index] % _BLOCK
        self._rngs[index].standard_normal(out=self._values[index, start:])
        self._drawn[index] += _BLOCK - start
