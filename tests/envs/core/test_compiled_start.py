"""Starts of episodes in compiled code are those of NumPy, in all environments or in some."""

from typing import Any

import gymnasium
import numpy as np
import pytest

import prp_gym
from prp_gym.envs.core.compiled_run import CompiledPeriods
from prp_gym.envs.core.period_source import PeriodSource
from prp_gym.symbolic.row_function import RowFunction
from prp_gym.tasks import SCENARIOS
from prp_gym.tasks.setup import COMPILED, MUJOCO
from tests.support.compiler import needs_compiler

pytestmark = needs_compiler

MASKS = ([True, True, True], [False, True, False], [True, True, False])


def made(environment_id: str, scenario: str, engine: str) -> Any:
    keywords: dict[str, Any] = {"scenario": scenario, "engine": engine, "duration": 1.0}
    return gymnasium.make_vec(environment_id, num_envs=3, **keywords)


def results(env: Any) -> list[Any]:
    """Everything that resets and the steps after them return, and the ground truth."""
    observation, _ = env.reset(seed=5)
    found = [observation]
    for mask in MASKS:
        observation, info = env.reset(options={"reset_mask": np.array(mask)})
        found += [observation, *info.values(), env.loop.ground_truth.copy(), env.loop.time]
        for _ in range(3):
            observation, reward, *_ = env.step(np.full(env.action_space.shape, 0.2))
            found += [observation, reward, env.loop.ground_truth.copy()]
    return found


def in_numpy(self: RowFunction, **arguments: Any) -> Any:
    return {name: values + 0.0 for name, values in self._formula(**arguments).items()}


@pytest.mark.parametrize("engine", [MUJOCO, COMPILED])
@pytest.mark.parametrize("scenario", SCENARIOS)
@pytest.mark.parametrize("environment_id", prp_gym.list_envs())
def test_starts_have_the_bits_of_numpy(
    environment_id: str, scenario: str, engine: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = results(made(environment_id, scenario, engine))
    monkeypatch.setattr(CompiledPeriods, "begin", lambda *_: False)
    monkeypatch.setattr(RowFunction, "__call__", in_numpy)
    for first, second in zip(found, results(made(environment_id, scenario, engine)), strict=True):
        np.testing.assert_array_equal(first, second)


@pytest.mark.parametrize("environment_id", prp_gym.list_envs())
def test_start_of_every_task_is_computed_in_compiled_code(environment_id: str) -> None:
    env = made(environment_id, "randomized", MUJOCO)
    env.reset(seed=0)
    assert PeriodSource(env.loop).begins


def test_start_that_cannot_be_traced_is_left_to_numpy(monkeypatch: pytest.MonkeyPatch) -> None:
    expected = results(made("PRP-Force-v0", "randomized", COMPILED))
    monkeypatch.setattr(PeriodSource, "_traced_start", lambda _: [])
    env = made("PRP-Force-v0", "randomized", COMPILED)
    for first, second in zip(results(env), expected, strict=True):
        np.testing.assert_array_equal(first, second)
    assert not PeriodSource(env.loop).begins
