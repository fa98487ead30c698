"""Many environments together are Gymnasium's SyncVectorEnv of single ones, bit for bit, in every mode."""

from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode, SyncVectorEnv

import prp_gym
from prp_gym.envs import PRPVectorEnv
from prp_gym.robot.arrays import Array

N = 5
MODES = [mode.value for mode in AutoresetMode]
IDS = prp_gym.list_envs()
SHORT = {"duration": 0.06, "control_frequency": 100}  # [s], [Hz]: six steps, so that many episodes end


def together(environment_id: str, mode: str, num_envs: int = N, **keywords: Any) -> PRPVectorEnv:
    env = gymnasium.make_vec(environment_id, num_envs, autoreset_mode=mode, **keywords)
    assert isinstance(env, PRPVectorEnv)
    return env


def one_by_one(environment_id: str, mode: str, num_envs: int = N, **keywords: Any) -> SyncVectorEnv:
    env = gymnasium.make_vec(
        environment_id, num_envs, "sync", vector_kwargs={"autoreset_mode": mode}, **keywords
    )
    assert isinstance(env, SyncVectorEnv)
    return env


def assert_same(found: Any, expected: Any, where: str) -> None:
    """Equal to the last bit, with the same types, in arrays, dictionaries and arrays of arrays."""
    assert type(found) is type(expected), where
    if isinstance(expected, dict):
        assert set(found) == set(expected), where
        for key in expected:
            assert_same(found[key], expected[key], f"{where}[{key!r}]")
    elif isinstance(expected, tuple):
        assert len(found) == len(expected), where
        for index, item in enumerate(expected):
            assert_same(found[index], item, f"{where}[{index}]")
    elif expected is None or expected.dtype != object:
        np.testing.assert_array_equal(found, expected, err_msg=where)
        if expected is not None:
            assert (found.dtype, found.shape) == (expected.dtype, expected.shape), where
    else:
        assert found.dtype == object, where
        for index, item in enumerate(expected):
            assert_same(found[index], item, f"{where}[{index}]")


def actions_for(env: Any, count: int, share: float = 1.2) -> list[Array]:
    """Random actions, some beyond the limits."""
    rng = np.random.default_rng(11)
    return [rng.uniform(-share, share, env.action_space.shape).astype(np.float32) for _ in range(count)]


@pytest.mark.parametrize("scenario", ["report", "randomized", "realistic"])
@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("environment_id", IDS)
def test_steps_and_restarts_are_those_of_single_environments(
    environment_id: str, mode: str, scenario: str
) -> None:
    keywords: dict[str, Any] = {"scenario": scenario, **SHORT}
    ours, theirs = together(environment_id, mode, **keywords), one_by_one(environment_id, mode, **keywords)
    assert_same(ours.reset(seed=7), theirs.reset(seed=7), "reset")
    # some are reset on their own, so that from then on episodes end at different steps
    again = np.zeros(N, dtype=np.bool_)
    for count, action in enumerate(actions_for(ours, 25)):
        if count == 3:
            again |= [True, False, False, True, False]
        if again.any():
            seeds = [100 + count, None, None, None, 5]
            found = ours.reset(seed=seeds, options={"reset_mask": again})
            assert_same(found, theirs.reset(seed=seeds, options={"reset_mask": again}), f"reset {count}")
        outcome = ours.step(action)
        assert_same(outcome, theirs.step(action), f"step {count}")
        again = (outcome[2] | outcome[3]) & (mode == "Disabled")
