"""The results of a step of N environments."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from prp_gym.robot.arrays import Array


class Step(NamedTuple):
    """The results of one step of N environments.

    Attributes:
        observation: Observations, a new array (N, size).
        reward: Rewards (N), each in [0, 1].
        terminated: Whether each simulation has diverged (N).
        truncated: Whether the duration of each episode is over (N).
        info: Values of the info fields (N, number of fields).
    """

    observation: Array
    reward: Array
    terminated: NDArray[np.bool_]
    truncated: NDArray[np.bool_]
    info: Array
