"""Steps per second at which Stable-Baselines3 trains, and the shares of its time."""

import time
from dataclasses import dataclass, replace
from typing import Any

import gymnasium
import torch
from stable_baselines3 import PPO, SAC
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.env_util import make_vec_env

import prp_gym
from bench.part_times import PartTimes, shares
from bench.rounds import ALL_CORES, FREE, LARGE_PPO, REACHER, Contender, Effort, Label
from bench.single import FREQUENCIES, REACHER_FREQUENCY, keywords

ROUNDS = 3
"""Maximum number of rounds, since training takes long."""


@dataclass(frozen=True)
class Recipe:
    """Recipe for training an agent.

    Attributes:
        name: Name of the section in the results.
        algorithm: Algorithm of Stable-Baselines3.
        num_envs: Number of environments N; with N = 1 it is not a vector environment.
        settings: Hyperparameters that differ from the library's defaults.
        steps: Number of steps of training before the measurement, and then in each round.
        unclocked_reacher: Whether Reacher-v5 is also trained without MuJoCo's clock.
    """

    name: str
    algorithm: type[BaseAlgorithm]
    num_envs: int
    settings: dict[str, Any]
    steps: int
    unclocked_reacher: bool = False


RECIPES = (
    Recipe(LARGE_PPO, PPO, 64, {"n_steps": 64, "batch_size": 1024}, 3 * 4096, True),
    Recipe("PPO, N = 8", PPO, 8, {}, 16384),
    Recipe("SAC, N = 1", SAC, 1, {}, 600),
    Recipe("SAC, N = 64", SAC, 64, {"gradient_steps": 1}, 6400),
)
"""Training recipes; everything not set here has the library's default."""


class Shares:
    """Shares of some calls of a model in the time of its training.

    Args:
        model: Model whose calls are timed from now on.

    Attributes:
        total: Time of all training since the start [s].
    """

    def __init__(self, model: BaseAlgorithm) -> None:
        self._times = PartTimes()
        self.total = 0.0
        self._times.count("train", model, "train")
        self._times.count("env_step", model.env, "step")
        self._times.count("policy", model.policy, "forward" if isinstance(model, PPO) else "predict")

    def describe(self) -> dict[str, float]:
        """Shares of the time; `other` is the rest."""
        return shares(self._times.seconds, self.total)


def make_model(recipe: Recipe, label: Label, duration: float) -> BaseAlgorithm:
    """An untrained agent."""
    settings = keywords(label, duration)
    env: Any
    if label.kind == "adapter":
        env = prp_gym.make_sb3_vec_env(label.environment, label.num_envs, num_threads=ALL_CORES, **settings)
    elif label.num_envs > 1:
        env = make_vec_env(label.environment, label.num_envs, env_kwargs=settings)
    else:
        env = gymnasium.make(label.environment, **settings)
    own = dict(recipe.settings)
    if "n_steps" in own:
        own["batch_size"] = min(own["batch_size"], own["n_steps"] * label.num_envs)
    return recipe.algorithm("MlpPolicy", env, seed=0, device="cpu", verbose=0, **own)


def contender(recipe: Recipe, label: Label, effort: Effort) -> tuple[Contender, Shares]:
    """An agent whose training has started, and the shares of its time."""
    model = make_model(recipe, label, effort.duration)
    steps = max(1, round(recipe.steps * effort.training_scale))
    model.learn(max(steps, 2 * getattr(model, "learning_starts", 0)))
    found = Shares(model)

    def rate(seconds: float) -> float:
        before, start = model.num_timesteps, time.perf_counter()
        model.learn(steps, reset_num_timesteps=False)
        elapsed = time.perf_counter() - start
        found.total += elapsed
        return (model.num_timesteps - before) / elapsed

    env: Any = model.env
    return Contender(label, rate, env.close), found


def labels(recipe: Recipe, num_envs: int) -> list[Label]:
    """Environments for training: Reacher-v5 as installed, and this suite without the clock."""
    kind, own, threads = ("dummy", "adapter", ALL_CORES) if num_envs > 1 else ("single", "single", 1)
    reacher = Label(kind, REACHER, REACHER_FREQUENCY, num_envs, clock=True)
    ours = [Label(own, FREE, frequency, num_envs, threads) for frequency in FREQUENCIES]
    if recipe.unclocked_reacher:
        ours.insert(0, replace(reacher, clock=False))
    return [reacher, *ours]


def contenders(recipe: Recipe, effort: Effort) -> tuple[list[Contender], dict[Label, Shares]]:
    """Agents of one recipe on every environment; PyTorch uses one thread."""
    torch.set_num_threads(1)
    count = min(recipe.num_envs, effort.library_size)
    made = [contender(recipe, label, effort) for label in labels(recipe, count)]
    return [one for one, _ in made], {one.label: found for one, found in made}
