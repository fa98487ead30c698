"""CleanRL: the environments that its scripts for continuous actions make, for PPO and for SAC and TD3."""

from collections.abc import Callable
from typing import Any

import gymnasium as gym
import numpy as np

import prp_gym  # noqa: F401 (registers the environments)


def for_ppo(gamma: float = 0.99) -> gym.Env[Any, Any]:
    """Make an environment as `ppo_continuous_action.py` does; Gymnasium 1 wants the third argument."""
    env = gym.make("PRP-Force-v0", duration=0.2)
    env = gym.wrappers.FlattenObservation(env)
    env = gym.wrappers.RecordEpisodeStatistics(env)
    env = gym.wrappers.ClipAction(env)
    env = gym.wrappers.NormalizeObservation(env)
    env = gym.wrappers.TransformObservation(env, lambda seen: np.clip(seen, -10, 10), env.observation_space)
    env = gym.wrappers.NormalizeReward(env, gamma=gamma)
    return gym.wrappers.TransformReward(env, lambda reward: np.clip(float(reward), -10, 10))


def for_sac() -> gym.Env[Any, Any]:
    """Make an environment as `sac_continuous_action.py` and `td3_continuous_action.py` do."""
    return gym.wrappers.RecordEpisodeStatistics(gym.make("PRP-Force-v0", duration=0.2))


def run(make: Callable[[], gym.Env[Any, Any]], mode: gym.vector.AutoresetMode) -> None:
    """Step two environments past the end of their episodes."""
    envs = gym.vector.SyncVectorEnv([make, make], autoreset_mode=mode)
    envs.reset(seed=1)
    for _ in range(250):
        *_, infos = envs.step(envs.action_space.sample())
        ended = infos.get("final_info", infos)
        if "episode" in ended:
            print(ended["episode"]["r"], ended["episode"]["l"])
    envs.close()


run(for_ppo, gym.vector.AutoresetMode.NEXT_STEP)
run(for_sac, gym.vector.AutoresetMode.SAME_STEP)
