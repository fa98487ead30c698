"""`Normalizer`: features scaled as they were in training."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from prp_gym.robot.arrays import Array


@dataclass(frozen=True, eq=False)
class Normalizer:
    """What Stable-Baselines3's VecNormalize does to observations, with its statistics as they are.

    Attributes:
        mean: of the features (features).
        variance: of the features (features).
        epsilon: added to the variance.
        clip: largest magnitude of a normalised feature.
    """

    mean: Array
    variance: Array
    epsilon: float
    clip: float

    def __call__(self, features: ArrayLike) -> Array:
        """Normalised features (..., features) of features (..., features)."""
        scaled = (np.asarray(features) - self.mean) / np.sqrt(self.variance + self.epsilon)
        return np.clip(scaled, -self.clip, self.clip)
