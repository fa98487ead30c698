"""One environment among those that Stable-Baselines3 steps together: attributes, methods, frames."""

from operator import methodcaller
from typing import Any

import gymnasium
import numpy as np
import pytest
from stable_baselines3.common.monitor import Monitor

from prp_gym.agents.sb3.vec_env import SB3VecEnv
from prp_gym.envs import PRPVectorEnv
from prp_gym.errors import EpisodeError, InvalidValueError
from tests.support.sb3_environments import ID, N, actions_for, assert_same_results, both, together


@pytest.mark.parametrize("indices", [None, 2, -1, [0, 3], (1,), range(1, 3), np.array([3, 1])])
def test_attributes_are_those_of_the_environments_asked_for(indices: Any) -> None:
    envs = both("PRP-Force-v0")
    for env in envs:
        env.seed(4)
        env.reset()
        env.step(actions_for(env, 1)[0])
    for name in (
        "ground_truth",
        "commanded_torque",
        "applied_torque",
        "torque_limit",
        "duration",
        "render_mode",
    ):
        assert_same_results(envs, methodcaller("get_attr", name, indices), name)
    assert_same_results(envs, lambda env: env.env_is_wrapped(Monitor, indices), "wrapped")
    for env in envs:
        env.set_attr("label", "mine", indices)
    holders = [[hasattr(view, "label") for view in env.envs] for env in (envs[0].together, envs[1])]
    assert holders[0] == holders[1]
    assert envs[0].get_attr("label", indices) == envs[1].get_attr("label", indices)
    draws = [env.env_method("get_wrapper_attr", indices=indices, name="np_random") for env in envs]
    assert [own.random() for own in draws[0]] == [own.random() for own in draws[1]]
    assert [env.has_attr("label") for env in envs] == [indices is None] * 2
    found = envs[0].env_method("get_wrapper_attr", "np_random", indices=indices)
    assert all(own is other for own, other in zip(found, draws[0], strict=True))
    with pytest.raises(AttributeError):
        envs[0].env_method("no_such_method", indices=indices)


@pytest.mark.parametrize("method", ["step", "reset"])
def test_one_among_many_is_neither_stepped_nor_reset_alone(method: str) -> None:
    env = together()
    with pytest.raises(EpisodeError, match="one of many"):
        env.env_method(method, *([np.zeros(3)] if method == "step" else []), indices=1)


@pytest.mark.parametrize("mode", ["NextStep", "Disabled"])
def test_other_autoreset_modes_are_refused(mode: str) -> None:
    vector = gymnasium.make_vec(ID, N, autoreset_mode=mode)
    assert isinstance(vector, PRPVectorEnv)
    with pytest.raises(InvalidValueError, match="SameStep"):
        SB3VecEnv(vector)


def test_metadata_and_modes_are_those_of_the_environments() -> None:
    env = together(render_mode="rgb_array", control_frequency=100)
    assert env.metadata == {"render_modes": ["rgb_array", "depth_array"], "render_fps": 100}
    assert env.render_mode == "rgb_array"
    assert env.spec is not None
    assert env.spec.id == ID
    assert env.unwrapped is env
    env.close()
    env.close()


def test_frames_are_those_of_single_environments_side_by_side(drawing: None) -> None:
    envs = both(render_mode="rgb_array", width=32, height=24)
    for env in envs:
        env.seed(2)
        env.reset()
    assert_same_results(envs, lambda env: list(env.get_images()), "images")
    assert_same_results(envs, methodcaller("render"), "side by side")
    tiled = envs[0].render()
    assert tiled is not None
    assert tiled.shape == (48, 64, 3)
    assert_same_results(envs, methodcaller("env_method", "render", indices=[3, 0]), "two of them")
    for env in envs:
        env.close()


def test_without_a_render_mode_there_are_no_frames() -> None:
    env = together()
    with pytest.warns(UserWarning, match="render_mode='rgb_array'; it is None"):
        assert list(env.get_images()) == [None] * N
    with pytest.warns(UserWarning, match="no `render_mode`"):
        assert env.render() is None
