"""`TipHistory`: where the tips of N environments were over the last second, and whether they touched."""

import numpy as np
from numpy.typing import NDArray

from prp_gym.envs.core.loop import EpisodeLoop
from prp_gym.robot.arrays import Array

DURATION = 1.0
"""Time over which positions are kept [s]."""

_FREQUENCY = 50.0  # of the kept positions, at most [Hz]


class TipHistory:
    """Positions of the tips, recorded after every step of environments that are drawn.

    What belongs to an earlier episode, or to a time before a restored state, is forgotten.

    Args:
        loop: Loop of the environments; it is given to every method, so that copies keep no loop of others.
    """

    def __init__(self, loop: EpisodeLoop) -> None:
        frequency, count = loop.config.control_frequency, loop.num_envs
        self._stride = max(1, round(frequency / _FREQUENCY))
        self._length = max(1, round(DURATION * frequency / self._stride))
        self._points = np.zeros((self._length, count, 3))
        self._kept = np.zeros(count, dtype=np.intp)  # positions of the present episode
        self._elapsed = np.full(count, -2)  # control periods
        self._last_force = np.zeros((count, 3))

    def record(self, loop: EpisodeLoop) -> None:
        """Record the state after a step."""
        elapsed = _elapsed(loop)
        new = elapsed != self._elapsed + 1
        if np.count_nonzero(new):
            self._kept[new] = 0
            self._last_force[new] = 0.0
        self._elapsed = elapsed
        force = loop.physics.contact_force
        if np.count_nonzero(force):
            touching = force.any(axis=1)
            self._last_force[touching] = force[touching]
        due = (elapsed % self._stride == 0) & (elapsed > 0)
        if np.count_nonzero(due):
            ids = np.flatnonzero(due)
            self._points[self._slots(elapsed[ids]), ids] = loop.physics.tip_position[ids]
            self._kept[ids] = np.minimum(self._kept[ids] + 1, self._length)

    def _slots(self, elapsed: NDArray[np.intp]) -> NDArray[np.intp]:
        """Rows in which positions are kept."""
        return elapsed // self._stride % self._length

    def points(self, loop: EpisodeLoop, index: int) -> Array:
        """Positions of one tip (k, 3) [m], the oldest first and the present one last."""
        now = loop.physics.tip_position[index][None]
        if not self._is_current(loop, index):
            return np.array(now)
        age = np.arange(self._kept[index])[::-1] * self._stride
        kept = self._points[self._slots(self._elapsed[index] - age), index]
        return np.array([*kept, now[0]])

    def last_force(self, loop: EpisodeLoop, index: int) -> Array:
        """The last contact force that was not zero in this episode (3) [N]; zero before the first contact."""
        force = loop.physics.contact_force[index]
        if force.any() or not self._is_current(loop, index):
            return np.array(force)
        return np.array(self._last_force[index])

    def _is_current(self, loop: EpisodeLoop, index: int) -> bool:
        """Whether the last recorded state of an environment is its present one."""
        return bool(_elapsed(loop)[index] == self._elapsed[index])


def _elapsed(loop: EpisodeLoop) -> NDArray[np.intp]:
    """Control periods since the start of each episode (N)."""
    return np.rint(loop.time * loop.config.control_frequency).astype(np.intp)
