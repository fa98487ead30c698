"""`EpisodeRecord`: whole episodes of N environments."""

from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from prp_gym.robot.arrays import Array


class EpisodeRecord(NamedTuple):
    """What happened in whole episodes of N environments.

    Attributes:
        ground_truth: Ground truth (N, T + 1, size).
        command: Commanded torque within the limits (N, T, joints) [N m, N, N m].
        applied: Applied torque (N, T, joints) [N m, N, N m].
        info: Values of `info` (N, T, fields).
        ended: Period (N), counted from 1, in which an environment diverged; 0 for none; negative where the
            action was not finite.
    """

    ground_truth: Array
    command: Array
    applied: Array
    info: Array
    ended: NDArray[np.intp]

    @classmethod
    def of(cls, loop: Any, periods: int) -> Self:
        """Room for episodes of a loop."""
        lead = (loop.num_envs, periods)
        return cls(
            np.empty((*lead, loop.ground_truth.shape[1])),
            np.empty((*lead, loop.joints)),
            np.empty((*lead, loop.joints)),
            np.empty((*lead, len(loop.info_fields))),
            np.zeros(loop.num_envs, dtype=np.intp),
        )
