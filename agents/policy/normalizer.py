"""`Normalizer`: normalisation of features with the statistics of training."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from prp_gym.robot.arrays import Array


@dataclass(frozen=True, eq=False)
class Normalizer:
    """Normalisation as by VecNormalize of Stable-Baselines3, with constant statistics.

    Attributes:
        mean: mean of each feature (features).
        variance: variance of each feature (features).
        epsilon: constant added to the variances.
        clip: largest magnitude of a normalised feature.
    """

    mean: Array
    variance: Array
    epsilon: float
    clip: float

    def __call__(self, features: ArrayLike) -> Array:
        """Normalised features (..., features), from features (..., features)."""
        scaled = (np.asarray(features) - self.mean) / np.sqrt(self.variance + self.epsilon)
        return np.clip(scaled, -self.clip, self.clip)
