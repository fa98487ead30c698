"""Conformance of environments in every action mode to Gymnasium and Stable-Baselines3."""

from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from stable_baselines3.common.env_checker import check_env as check_env_for_sb3

from tests.support.mode_episodes import COVERING, KINDS, made

SHORT: dict[str, Any] = {"control_frequency": 50, "duration": 0.04}


@pytest.mark.parametrize(("environment_id", "mode"), COVERING)
def test_checkers_are_satisfied(environment_id: str, mode: str) -> None:
    check_env(made(environment_id, mode, **SHORT), skip_render_check=True)
    check_env_for_sb3(made(environment_id, mode, **SHORT), warn=True, skip_render_check=True)


@pytest.mark.parametrize(("environment_id", "mode"), KINDS)
def test_environment_is_made_again_from_its_spec(environment_id: str, mode: str) -> None:
    env = gymnasium.make(environment_id, action_mode=mode, **SHORT)
    assert env.spec is not None
    again = gymnasium.make(gymnasium.envs.registration.EnvSpec.from_json(env.spec.to_json()))
    assert again.get_wrapper_attr("action_mode") == mode
    assert again.action_space == env.action_space


@pytest.mark.parametrize("wild", [1.0, -1.0])
@pytest.mark.parametrize(("environment_id", "mode"), KINDS)
def test_observation_stays_in_its_space_under_full_actions(
    environment_id: str, mode: str, wild: float
) -> None:
    env = made(environment_id, mode, control_frequency=10, duration=0.2)
    observation, _ = env.reset(seed=3)
    over = False
    while not over:
        assert env.observation_space.contains(observation)
        action = np.full(env.action_space.shape or (), 2.0 * wild, dtype=np.float32)  # clipped
        observation, reward, terminated, over, info = env.step(action)
        assert not terminated
        assert 0.0 <= reward <= 1.0
        assert np.isfinite(list(info.values())).all()


def test_frames_are_drawn_once_for_each_action(drawing: None) -> None:
    env = made("PRP-Impedance-v0", "impedance", control_frequency=50, render_mode="rgb_array", width=64)
    env.reset(seed=0)
    before = env.render()
    env.step(np.ones(5))
    after = env.render()
    assert before is not None
    assert after is not None
    assert after.shape == (480, 64, 3)
    assert not np.array_equal(before, after)
    assert env.metadata["render_fps"] == 50
    env.close()
