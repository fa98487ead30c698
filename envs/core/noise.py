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

    def next_steps(self, steps: int, *, with_present: bool) -> Array:
        """The numbers of many steps, and go on by as many.

        Args:
            steps: Number of steps.
            with_present: Whether the first of them is the present step, or the one after it.

        Returns:
            (steps, N, size).
        """
        if steps == 1:
            present = self.current if with_present else None
            self.advance()
            return (self.current if present is None else present)[None]
        values, done = np.empty((steps, len(self._values), self._values.shape[2])), 0
        while done < steps:
            if not with_present:
                self.advance()
            block = self._block(steps - done)
            values[done : done + len(block)] = block
            self._steps += len(block) - 1
            done += len(block)
            if with_present:
                self.advance()
        return values

    def _block(self, most: int) -> Array:
        """Numbers from the present step on (n, N, size), for as long as they are drawn, but at most some."""
        first, drawn = int(self._steps[0]), int(self._drawn[0])
        if (self._steps != first).any() or (self._drawn != drawn).any():
            return self.current[None]
        count, start = min(most, drawn - first), first % _BLOCK
        return self._values[:, start : start + count].swapaxes(0, 1)

    def _draw_to_end_of_block(self, index: int) -> None:
        """Draw the numbers of one environment from its present step to the end of the block."""
        start = self._steps[index] % _BLOCK
        self._rngs[index].standard_normal(out=self._values[index, start:])
        self._drawn[index] += _BLOCK - start
