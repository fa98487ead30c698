"""`TrackingFeaturesVecEnv`: environments whose observations are features for a network."""

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import ArrayLike, NDArray
from stable_baselines3.common.vec_env import VecEnv, VecEnvWrapper
from stable_baselines3.common.vec_env.base_vec_env import VecEnvStepReturn

from prp_gym.agents.policy.features import TrackingFeatures


class TrackingFeaturesVecEnv(VecEnvWrapper):
    """Environments that give `TrackingFeatures` of what they observe, also of the last step of an episode.

    Features are float32: replay buffers of half the size, and a rounding far below any sensor's noise.

    Args:
        venv: of this suite.

    Attributes:
        features: that are given.
    """

    def __init__(self, venv: VecEnv) -> None:
        self.features = TrackingFeatures(venv.get_attr("observation_layout", 0)[0])
        space = Box(-np.inf, np.inf, (self.features.size,), dtype=np.float32)
        super().__init__(venv, observation_space=space)

    def reset(self) -> NDArray[np.float32]:
        """Start an episode in every environment; features (N, size)."""
        return self._features(self.venv.reset())  # type: ignore[arg-type]

    def step_wait(self) -> VecEnvStepReturn:
        """One control period; features (N, size) in place of observations."""
        observation, reward, done, infos = self.venv.step_wait()
        for index in np.flatnonzero(done):
            infos[index]["terminal_observation"] = self._features(infos[index]["terminal_observation"])
        return self._features(observation), reward, done, infos  # type: ignore[arg-type]

    def _features(self, observation: ArrayLike) -> NDArray[np.float32]:
        return self.features(observation).astype(np.float32)
