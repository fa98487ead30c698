"""Steps per second at which Stable-Baselines3 trains, and the shares of its time."""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import wraps
from typing import Any

import gymnasium
import torch
from stable_baselines3 import PPO, SAC
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.env_util import make_vec_env

import prp_gym
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
        seconds: Time of each part since the start [s].
        total: Time of all training since the start [s].
    """

    def __init__(self, model: BaseAlgorithm) -> None:
        self.seconds = {"train": 0.0, "env_step": 0.0, "policy": 0.0}
        self.total = 0.0
        policy = "forward" if isinstance(model, PPO) else "predict"
        for part, owner, name in (
            ("train", model, "train"),
            ("env_step", model.env, "step"),
            ("policy", model.policy, policy),
        ):
            setattr(owner, name, self._timed(part, getattr(owner, name)))

    def _timed(self, part: str, call: Callable[..., Any]) -> Callable[..., Any]:
        @wraps(call)
        def timed(*arguments: Any, **settings: Any) -> Any:
            start = time.perf_counter()
            try:
                return call(*arguments, **settings)
            finally:
                self.seconds[part] += time.perf_counter() - start

        return timed

    def describe(self) -> dict[str, float]:
        """Shares of the time; `other` is the rest."""
        shares = {part: seconds / self.total for part, seconds in self.seconds.items()}
        return {**shares, "other": 1.0 - sum(shares.values())}


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
    shares = Shares(model)

    def rate(seconds: float) -> float:
        before, start = model.num_timesteps, time.perf_counter()
        model.learn(steps, reset_num_timesteps=False)
        elapsed = time.perf_counter() - start
        shares.total += elapsed
        return (model.num_timesteps - before) / elapsed

    env: Any = model.env
    return Contender(label, rate, env.close), shares


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
    return [one for one, _ in made], {one.label: shares for one, shares in made}
