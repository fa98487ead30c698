"""Small trainings for tests: the single link, one second at 50 Hz."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from prp_gym.agents.recipes import Recipe, load_recipe
from prp_gym.agents.training import TrainingJob

ID = "PRP-Adaptive-v0"
SHORT = ("env_kwargs.control_frequency=50", "env_kwargs.duration=1", "gamma=0.9")
TINY = {
    "ppo": (
        *SHORT,
        "n_timesteps=512",
        "n_envs=4",
        "n_steps=32",
        "batch_size=64",
        "n_epochs=2",
        "policy_kwargs.net_arch=[8]",
    ),
    "sac": (
        *SHORT,
        "n_timesteps=400",
        "n_envs=4",
        "batch_size=16",
        "buffer_size=1000",
        "learning_starts=100",
        "policy_kwargs.net_arch=[8]",
    ),
}
TINY["td3"] = TINY["tqc"] = TINY["sac"]
TINY["recurrent_ppo"] = (*TINY["ppo"], "policy_kwargs.lstm_hidden_size=8")


def tiny_recipe(algorithm: str = "ppo", more: Sequence[str] = ()) -> Recipe:
    """Of a training that takes a fraction of a second and learns nothing."""
    return load_recipe(algorithm, ID, overrides=(*TINY[algorithm], *more))


def tiny_job(folder: Path, algorithm: str = "ppo", more: Sequence[str] = (), **settings: Any) -> TrainingJob:
    """A job of a tiny recipe, without TensorBoard."""
    recipe = tiny_recipe(algorithm, more)
    given = {"seed": 0, "eval_every": 128, "eval_episodes": 4, "tensorboard": False, **settings}
    return TrainingJob(recipe, folder=folder, **given)
