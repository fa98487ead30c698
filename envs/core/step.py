"""What a step of N environments returns."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from prp_gym.robot.arrays import Array


class Step(NamedTuple):
    """What one step of N environments returned.

    Attributes:
        observation: (N, size), new.
        reward: (N) [s].
        terminated: (N), diverged.
        truncated: (N), the episode's duration is over.
        info: (N, number of info fields).
    """

    observation: Array
    reward: Array
    terminated: NDArray[np.bool_]
    truncated: NDArray[np.bool_]
    info: Array
