"""`Learner`: a model in training and its environments, made from a recipe."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.logger import Logger
from stable_baselines3.common.vec_env import VecNormalize

from prp_gym.agents.algorithms import ALGORITHMS
from prp_gym.agents.policy.normalizer import Normalizer
from prp_gym.agents.sb3.arguments import constructor_arguments
from prp_gym.agents.sb3.feature_vec_env import TrackingFeaturesVecEnv
from prp_gym.agents.sb3.make_vec_env import make_sb3_vec_env
from prp_gym.agents.training.recipes import EPISODES_A_SEED, Recipe
from prp_gym.errors import InvalidValueError


@dataclass(frozen=True)
class Learner:
    """A model in training and its environments.

    Attributes:
        model: model of Stable-Baselines3.
        env: environments of the model, with the running statistics that normalise its features.
    """

    model: BaseAlgorithm
    env: VecNormalize

    @property
    def normalizer(self) -> Normalizer:
        """The present normaliser of the features; an identity if the recipe does not normalise them."""
        if not self.env.norm_obs:
            size = int(np.prod(self.env.observation_space.shape or ()))
            return Normalizer(np.zeros(size), np.ones(size), 0.0, np.inf)
        statistics: Any = self.env.obs_rms
        return Normalizer(statistics.mean.copy(), statistics.var.copy(), self.env.epsilon, self.env.clip_obs)

    def close(self) -> None:
        """Free the environments."""
        self.env.close()


def make_learner(recipe: Recipe, seed: int, resumes: int = 0) -> Learner:
    """An untrained model with its environments; PyTorch is set to compute in one thread.

    Args:
        recipe: recipe of the training.
        seed: training seed.
        resumes: number of times that training was resumed; each time, new episodes have other seeds.

    Raises:
        InvalidValueError: settings that the algorithm's constructor refuses.
        PRPError: keywords that the environment refuses.
    """
    torch.set_num_threads(1)
    keywords: dict[str, Any] = dict(recipe.env_kwargs)
    made = make_sb3_vec_env(recipe.environment_id, recipe.n_envs, num_threads=1, seed=seed, **keywords)
    gamma = float(recipe.settings.get("gamma", 0.99))
    env = VecNormalize(
        TrackingFeaturesVecEnv(made),
        norm_obs=recipe.normalize["obs"],
        norm_reward=recipe.normalize["reward"],
        gamma=gamma,
    )
    action_size = int(np.prod(env.action_space.shape or ()))
    arguments = constructor_arguments(recipe.settings, action_size)
    kind: Any = ALGORITHMS.find(recipe.algorithm).load_class()
    try:
        model: BaseAlgorithm = kind(recipe.policy, env, seed=seed, device="cpu", verbose=0, **arguments)
    except (AssertionError, MemoryError, RuntimeError, TypeError, ValueError) as error:
        allowed = f"what {kind.__name__} takes ({error})"
        raise InvalidValueError(
            f"recipe's settings of {recipe.algorithm}", recipe.settings, allowed
        ) from error
    model.set_logger(Logger(None, []))  # or `learn` would make one, with a folder for temporary files
    env.seed((seed + 1) * EPISODES_A_SEED + resumes * recipe.n_envs)  # the constructor seeded them otherwise
    return Learner(model, env)
