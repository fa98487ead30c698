"""`EpisodeTotals`: what whole episodes have given, without a recording."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from prp_gym.robot.arrays import Array


class EpisodeTotals(NamedTuple):
    """What whole episodes have given.

    Attributes:
        reward: sum of the rewards (episodes), up to the end of the episode [1].
        ended: control period (episodes), counted from 1, in which an episode diverged; 0 for none; negative
            where an action was not finite, of which nothing else is known.
    """

    reward: Array
    ended: NDArray[np.intp]
