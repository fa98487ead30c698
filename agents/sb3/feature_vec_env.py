"""`TrackingFeaturesVecEnv`: vectorised environments whose observations are features for a network."""

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import ArrayLike, NDArray
from stable_baselines3.common.vec_env import VecEnv, VecEnvWrapper
from stable_baselines3.common.vec_env.base_vec_env import VecEnvStepReturn

from prp_gym.agents.policy.features import TrackingFeatures


class TrackingFeaturesVecEnv(VecEnvWrapper):
    """Wrapper that returns `TrackingFeatures` of the observations, also of an episode's last observation.

    Features are float32: they halve the size of replay buffers and round far below any sensor noise.

    Args:
        venv: vectorised environments of this suite.

    Attributes:
        features: function from observations to features.
    """

    def __init__(self, venv: VecEnv) -> None:
        self.features = TrackingFeatures(venv.get_attr("observation_layout", 0)[0])
        space = Box(-np.inf, np.inf, (self.features.size,), dtype=np.float32)
        super().__init__(venv, observation_space=space)

    def reset(self) -> NDArray[np.float32]:
        """Start an episode in every environment and return the features (N, size)."""
        return self._features(self.venv.reset())  # type: ignore[arg-type]

    def step_wait(self) -> VecEnvStepReturn:
        """Advance one control period; features (N, size) take the place of observations."""
        observation, reward, done, infos = self.venv.step_wait()
        for index in np.flatnonzero(done):
            infos[index]["terminal_observation"] = self._features(infos[index]["terminal_observation"])
        return self._features(observation), reward, done, infos  # type: ignore[arg-type]

    def _features(self, observation: ArrayLike) -> NDArray[np.float32]:
        return self.features(observation).astype(np.float32)
