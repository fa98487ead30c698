"""Small trainings for tests: the single link, one second at 50 Hz; and how to compare what comes out."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import torch

from prp_gym.agents.algorithms import ALGORITHMS
from prp_gym.agents.training.model import Learner, make_learner
from prp_gym.agents.training.recipes import Recipe, load_recipe
from prp_gym.agents.training.train import TrainingJob
from prp_gym.agents.training.training_state import BestPolicy, CurveRow, TrainingState, Violations

ID = "PRP-Adaptive-v0"
SHORT = ("env_kwargs.control_frequency=50", "env_kwargs.duration=1", "gamma=0.9")
TINY: dict[str, tuple[str, ...]] = {
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
        "train_freq=4",
        "policy_kwargs.net_arch=[8]",
    ),
}
TINY["td3"] = TINY["tqc"] = TINY["sac"]
TINY["recurrent_ppo"] = (*TINY["ppo"], "policy_kwargs.lstm_hidden_size=8")
for _name in set(ALGORITHMS) - set(TINY):  # of one that is new, with keys that every recipe has
    TINY[_name] = (*SHORT, "n_timesteps=512", "n_envs=4", "policy_kwargs.net_arch=[8]")


def tiny_recipe(algorithm: str = "ppo", more: Sequence[str] = ()) -> Recipe:
    """Of a training that takes a fraction of a second and learns nothing."""
    return load_recipe(algorithm, ID, overrides=(*TINY[algorithm], *more))


def tiny_job(folder: Path, algorithm: str = "ppo", more: Sequence[str] = (), **settings: Any) -> TrainingJob:
    """A job of a tiny recipe, without TensorBoard."""
    recipe = tiny_recipe(algorithm, more)
    given = {"seed": 0, "eval_every": 128, "eval_episodes": 4, "tensorboard": False, **settings}
    return TrainingJob(recipe, folder=folder, **given)


def interrupted(rows: int) -> Any:
    """A report that ends training at so many evaluations."""
    seen: list[CurveRow] = []

    def report(row: CurveRow) -> None:
        seen.append(row)
        if len(seen) == rows:
            raise KeyboardInterrupt

    return report


def weights_of(folder: Path) -> dict[str, Any]:
    loaded: dict[str, Any] = torch.load(folder / "best.pt", weights_only=True)
    return loaded


def assert_same_weights(folder: Path, other: Path) -> None:
    first, second = weights_of(folder), weights_of(other)
    assert list(first) == list(second)
    for name, values in first.items():
        assert torch.equal(values, second[name]), name


def read(path: Path) -> Any:
    return json.loads(path.read_text(encoding="utf-8"))


def trained(algorithm: str, seed: int = 0) -> tuple[Learner, TrainingState]:
    """A learner after some updates, with a state to keep."""
    learner = make_learner(tiny_recipe(algorithm), seed)
    learner.model.learn(256)
    best = BestPolicy(128, 0.5, learner.model.policy.state_dict(), learner.normalizer)
    row = CurveRow(128, 1.5, 0.5, {"joint_stop": 1.0, "force_bound": 2.0, "divergences": 3})
    return learner, TrainingState([row], Violations(1.0, 2.0, 3), 2.5, 0.5, 4, [best])


def assert_equal(found: Any, expected: Any) -> None:
    """Equal to the last bit, in tensors, arrays, dictionaries and lists."""
    if isinstance(expected, dict):
        assert list(found) == list(expected)
        for key in expected:
            assert_equal(found[key], expected[key])
    elif isinstance(expected, list | tuple):
        assert len(found) == len(expected)
        for item, other in zip(found, expected, strict=True):
            assert_equal(item, other)
    elif isinstance(expected, torch.Tensor | np.ndarray):
        np.testing.assert_array_equal(np.asarray(found), np.asarray(expected))
    else:
        assert found == expected
