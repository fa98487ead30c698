"""Helpers for tests of vector environments: making them, recording their results, exact comparison."""

from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from numpy.typing import NDArray

import prp_gym
from prp_gym.envs import PRPEnv, PRPVectorEnv
from prp_gym.robot.arrays import Array

MODES = [mode.value for mode in AutoresetMode]
IDS = prp_gym.list_envs()
SHORT: dict[str, Any] = {
    "duration": 0.06,
    "control_frequency": 100,
}  # [s], [Hz]: six steps, so that many episodes end

Outcome = tuple[bytes, bytes, bool, bool, dict[str, Any]]
"""The exact results of one environment: observation, reward, ends, and its own `info`."""


def together(environment_id: str, mode: str = "NextStep", num_envs: int = 5, **keywords: Any) -> PRPVectorEnv:
    env = gymnasium.make_vec(environment_id, num_envs, autoreset_mode=mode, **keywords)
    assert isinstance(env, PRPVectorEnv)
    return env


def one_by_one(
    environment_id: str, mode: str = "NextStep", num_envs: int = 5, **keywords: Any
) -> SyncVectorEnv:
    env = gymnasium.make_vec(
        environment_id, num_envs, "sync", vector_kwargs={"autoreset_mode": mode}, **keywords
    )
    assert isinstance(env, SyncVectorEnv)
    return env


def single(environment_id: str, **keywords: Any) -> PRPEnv:
    env = gymnasium.make(environment_id, **keywords).unwrapped
    assert isinstance(env, PRPEnv)
    return env


def assert_same(found: Any, expected: Any, where: str) -> None:
    """Equal to the last bit, with the same types, in arrays, dictionaries and arrays of arrays."""
    assert type(found) is type(expected), where
    if isinstance(expected, dict):
        assert set(found) == set(expected), where
        for key in expected:
            assert_same(found[key], expected[key], f"{where}[{key!r}]")
    elif isinstance(expected, (tuple, list)):
        assert len(found) == len(expected), where
        for index, item in enumerate(expected):
            assert_same(found[index], item, f"{where}[{index}]")
    elif isinstance(expected, np.ndarray) and expected.dtype == object:
        assert found.dtype == object, where
        assert_same(found.tolist(), expected.tolist(), where)
    elif isinstance(expected, np.ndarray):
        np.testing.assert_array_equal(found, expected, err_msg=where)
        assert (found.dtype, found.shape) == (expected.dtype, expected.shape), where
    else:
        assert found == expected, where


def actions_for(env: Any, count: int, share: float = 1.2) -> list[Array]:
    """Random actions, some beyond the limits."""
    rng = np.random.default_rng(11)
    return [rng.uniform(-share, share, env.action_space.shape).astype(np.float32) for _ in range(count)]


def own_info(info: dict[str, Any], index: int) -> dict[str, Any]:
    """The `info` of one environment: the numbers that belong to it by their masks."""
    own: dict[str, Any] = {}
    for name, values in info.items():
        if name.startswith("_") or not info[f"_{name}"][index]:
            continue
        own[name] = own_info(values, index) if isinstance(values, dict) else bits(values[index])
    return own


def bits(value: object) -> bytes:
    return np.asarray(value, dtype=np.float64).tobytes()


def outcomes(step: tuple[Any, ...]) -> list[Outcome]:
    """The results of each environment in a step of all."""
    observation, reward, terminated, truncated, info = step
    return [
        (
            bits(observation[index]),
            bits(reward[index]),
            bool(terminated[index]),
            bool(truncated[index]),
            own_info(info, index),
        )
        for index in range(len(reward))
    ]


def run_together(env: Any, seed: Any, actions: NDArray[Any], again: int = 3) -> list[list[Outcome]]:
    """The results of each environment in each step.

    Every third environment is reset before step `again`, so that episodes end at different steps.
    """
    mask = np.arange(env.num_envs) % 3 == 0
    observation, _ = env.reset(seed=seed)
    history: list[list[Outcome]] = [[(bits(row), b"", False, False, {}) for row in observation]]
    for count, action in enumerate(actions):
        if count == again:
            env.reset(options={"reset_mask": mask})
        history.append(outcomes(env.step(action)))
    return history


def run_alone(env: PRPEnv, seed: int, actions: NDArray[Any], again: int) -> list[Outcome]:
    """The same for a single environment, which is reset in the step that ends an episode."""
    observation, _ = env.reset(seed=seed)
    history: list[Outcome] = [(bits(observation), b"", False, False, {})]
    for count, action in enumerate(actions):
        if count == again:
            env.reset()
        observation, reward, terminated, truncated, info = env.step(action)
        own: dict[str, Any] = {name: bits(value) for name, value in info.items()}
        if terminated or truncated:
            final = bits(observation)
            observation, start = env.reset()
            begun = {name: bits(value) for name, value in start.items()}
            own = {"final_obs": final, "final_info": own, **begun}
        history.append((bits(observation), bits(reward), terminated, truncated, own))
    return history


def assert_history(found: list[Outcome], expected: list[Outcome], where: str) -> None:
    """Assert equal results of one environment, with the first step that differs."""
    assert len(found) == len(expected), where
    for step, (ours, theirs) in enumerate(zip(found, expected, strict=True)):
        for what, mine, others in zip(("obs", "reward", "end", "end", "info"), ours, theirs, strict=True):
            assert mine == others, f"{where}, step {step}: {what}"


def history_of(history: list[list[Outcome]], index: int) -> list[Outcome]:
    return [step[index] for step in history]
