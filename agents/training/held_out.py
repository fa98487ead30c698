"""Evaluation of a policy in training, on episodes that are not used for training."""

from typing import Any

import numpy as np
from stable_baselines3.common.base_class import BaseAlgorithm

from prp_gym.agents.policy.normalizer import Normalizer
from prp_gym.agents.sb3.feature_vec_env import TrackingFeaturesVecEnv
from prp_gym.agents.sb3.make_vec_env import make_sb3_vec_env
from prp_gym.agents.training.recipes import FIRST_HELD_OUT_SEED, Recipe


class HeldOutEpisodes:
    """Held-out episodes, run in parallel environments.

    Args:
        recipe: recipe of the training, which names the environment.
        episodes: number of episodes.
    """

    def __init__(self, recipe: Recipe, episodes: int) -> None:
        keywords: dict[str, Any] = dict(recipe.env_kwargs)
        made = make_sb3_vec_env(
            recipe.environment_id, episodes, seed=FIRST_HELD_OUT_SEED, num_threads=1, **keywords
        )
        self._horizon = int(made.get_attr("config", 0)[0].horizon)
        self._env = TrackingFeaturesVecEnv(made)

    def score(self, model: BaseAlgorithm, normalizer: Normalizer) -> float:
        """Mean reward over the planned steps of the episodes, in [0, 1], for the deterministic policy.

        Args:
            model: model in training, which is not changed.
            normalizer: present normaliser of the features.
        """
        self._env.seed(FIRST_HELD_OUT_SEED)
        features = np.asarray(self._env.reset())
        count = self._env.num_envs
        returns, running = np.zeros(count), np.ones(count, dtype=np.bool_)
        state, begins = None, np.ones(count, dtype=np.bool_)
        while running.any():
            given = normalizer(features).astype(np.float32)
            actions, state = model.predict(given, state=state, episode_start=begins, deterministic=True)
            step = self._env.step(actions)
            features, begins = np.asarray(step[0]), step[2]
            returns += np.where(running, step[1], 0.0)
            running &= ~begins
        return float(np.mean(returns) / self._horizon)

    def close(self) -> None:
        """Free the environments."""
        self._env.close()
