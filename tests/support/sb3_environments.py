"""The adapter for Stable-Baselines3 beside its DummyVecEnv of single environments."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import DummyVecEnv, VecEnv

import prp_gym  # noqa: F401 (registers the environments)
from prp_gym.agents.sb3.vec_env import SB3VecEnv
from prp_gym.envs import PRPVectorEnv

N = 4
ID = "PRP-JointRegulation-v0"
SHORT: dict[str, Any] = {"duration": 0.06, "control_frequency": 100}  # [s], [Hz]: episodes of six steps


def together(environment_id: str = ID, **keywords: Any) -> SB3VecEnv:
    vector = gymnasium.make_vec(environment_id, N, autoreset_mode="SameStep", **{**SHORT, **keywords})
    assert isinstance(vector, PRPVectorEnv)
    return SB3VecEnv(vector)


def one_by_one(environment_id: str = ID, **keywords: Any) -> DummyVecEnv:
    return DummyVecEnv([partial(gymnasium.make, environment_id, **{**SHORT, **keywords})] * N)


def both(environment_id: str = ID, **keywords: Any) -> tuple[SB3VecEnv, DummyVecEnv]:
    return together(environment_id, **keywords), one_by_one(environment_id, **keywords)


def actions_for(env: VecEnv, count: int, wild: Sequence[float] = (1.2,) * N) -> list[NDArray[Any]]:
    """Random actions, some beyond the limits; how large, for each environment."""
    rng = np.random.default_rng(11)
    size = (N, *(env.action_space.shape or ()))
    return [(np.array(wild)[:, None] * rng.uniform(-1, 1, size)).astype(np.float32) for _ in range(count)]


def assert_same(found: Any, expected: Any, where: str) -> None:
    """Equal to the last bit, with the same types, in arrays, lists and dictionaries in their order."""
    assert type(found) is type(expected), where
    if isinstance(expected, dict):
        assert list(found) == list(expected), where
        for key in expected:
            assert_same(found[key], expected[key], f"{where}[{key!r}]")
    elif isinstance(expected, list | tuple):
        assert len(found) == len(expected), where
        for index, item in enumerate(expected):
            assert_same(found[index], item, f"{where}[{index}]")
    elif isinstance(expected, np.ndarray):
        assert (found.dtype, found.shape) == (expected.dtype, expected.shape), where
        np.testing.assert_array_equal(found, expected, err_msg=where)
    else:
        assert found == expected, where


def assert_same_episodes(ours: VecEnv, theirs: VecEnv, actions: Sequence[NDArray[Any]]) -> list[Any]:
    """Run both, compare them and return the results of the first."""
    steps = []
    ours.seed(7)
    theirs.seed(7)
    assert_same(ours.reset(), theirs.reset(), "reset")
    for count, action in enumerate(actions):
        steps.append(ours.step(action))
        assert_same(steps[-1], theirs.step(action), f"step {count}")
        assert_same(ours.reset_infos, theirs.reset_infos, f"reset infos {count}")
    return steps


def assert_same_results(environments: Sequence[VecEnv], call: Callable[[Any], Any], where: str) -> None:
    """Assert that a call returns the same bits for both environments."""
    ours, theirs = (call(env) for env in environments)
    assert_same(ours, theirs, where)
