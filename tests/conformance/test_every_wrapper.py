"""Every wrapper that Gymnasium names runs on the environments, single and together."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium import wrappers
from gymnasium.wrappers import vector

from prp_gym.envs import PRPEnv
from tests.support.vector_episodes import SHORT

FORCE = "PRP-Force-v0"
STEPS = 6  # those of an episode
SIZE = 42  # of an observation
ACTIONS = np.full(3, -2.0, dtype=np.float32), np.full(3, 2.0, dtype=np.float32)
Make = Callable[[], Any]


def plain() -> Any:
    return gymnasium.make(FORCE, **SHORT)


def filmed() -> Any:
    return gymnasium.make(FORCE, render_mode="rgb_array", width=32, height=32, **SHORT)


def pixels() -> Any:
    return wrappers.AddRenderObservation(filmed())


def timed() -> Any:
    return wrappers.TimeAwareObservation(plain(), flatten=False)


def several() -> Any:
    return gymnasium.make_vec(FORCE, 2, **SHORT)


def films() -> Any:
    return gymnasium.make_vec(FORCE, 2, render_mode="rgb_array", width=32, height=32, **SHORT)


def several_of(make: Make) -> Any:
    return gymnasium.vector.SyncVectorEnv([make, make])


SINGLE: dict[str, tuple[Make, dict[str, Any]]] = {
    "AddRenderObservation": (filmed, {}),
    "AddWhiteNoise": (pixels, {"probability_of_noise_per_pixel": 0.1}),
    "ArrayConversion": (plain, {"env_xp": np, "target_xp": np}),
    "Autoreset": (plain, {}),
    "ClipAction": (plain, {}),
    "ClipReward": (plain, {"min_reward": 0.0, "max_reward": 0.005}),
    "DelayObservation": (plain, {"delay": 2}),
    "DiscretizeAction": (plain, {"bins": 3}),
    "DiscretizeObservation": (plain, {"bins": 3, "multidiscrete": True}),
    "DtypeObservation": (plain, {"dtype": np.float32}),
    "FilterObservation": (timed, {"filter_keys": ["obs"]}),
    "FlattenObservation": (timed, {}),
    "FrameStackObservation": (plain, {"stack_size": 3}),
    "GrayscaleObservation": (pixels, {}),
    "MaxAndSkipObservation": (plain, {"skip": 2}),
    "NormalizeObservation": (plain, {}),
    "NormalizeReward": (plain, {}),
    "NumpyToTorch": (plain, {}),
    "ObstructView": (pixels, {"obstructed_pixels_ratio": 0.2, "obstruction_width": 4}),
    "OrderEnforcing": (plain, {}),
    "PassiveEnvChecker": (plain, {}),
    "RecordEpisodeStatistics": (plain, {}),
    "RecordVideo": (filmed, {"video_folder": "films"}),
    "RenderCollection": (filmed, {}),
    "RepeatAction": (plain, {"num_repeats": 2}),
    "RescaleAction": (plain, {"min_action": ACTIONS[0], "max_action": ACTIONS[1]}),
    "RescaleObservation": (plain, {"min_obs": np.full(SIZE, -1.0), "max_obs": np.full(SIZE, 1.0)}),
    "ReshapeObservation": (plain, {"shape": (2, SIZE // 2)}),
    "ResizeObservation": (pixels, {"shape": (16, 16)}),
    "StickyAction": (plain, {"repeat_action_probability": 0.5}),
    "TimeAwareObservation": (plain, {}),
    "TimeLimit": (plain, {"max_episode_steps": 4}),
    "TransformAction": (plain, {"func": np.negative, "action_space": None}),
    "TransformObservation": (plain, {"func": np.copy, "observation_space": None}),
    "TransformReward": (plain, {"func": np.negative}),
}
TOGETHER: dict[str, tuple[Make, dict[str, Any]]] = {
    "ArrayConversion": (several, {"env_xp": np, "target_xp": np}),
    "ClipAction": (several, {}),
    "ClipReward": (several, {"min_reward": 0.0, "max_reward": 0.005}),
    "DictInfoToList": (several, {}),
    "DtypeObservation": (several, {"dtype": np.float32}),
    "FilterObservation": (lambda: several_of(timed), {"filter_keys": ["obs"]}),
    "FlattenObservation": (lambda: several_of(timed), {}),
    "GrayscaleObservation": (lambda: several_of(pixels), {}),
    "NormalizeObservation": (several, {}),
    "NormalizeReward": (several, {}),
    "NumpyToTorch": (several, {}),
    "RecordEpisodeStatistics": (several, {}),
    "RecordVideo": (films, {"video_folder": "films"}),
    "RescaleAction": (several, {"min_action": ACTIONS[0], "max_action": ACTIONS[1]}),
    "RescaleObservation": (several, {"min_obs": np.full(SIZE, -1.0), "max_obs": np.full(SIZE, 1.0)}),
    "ReshapeObservation": (several, {"shape": (2, SIZE // 2)}),
    "ResizeObservation": (lambda: several_of(pixels), {"shape": (16, 16)}),
    "TransformAction": (several, {"func": np.negative}),
    "TransformObservation": (several, {"func": np.copy}),
    "TransformReward": (several, {"func": np.negative}),
    "VectorizeTransformAction": (several, {"wrapper": wrappers.ClipAction}),
    "VectorizeTransformObservation": (
        several,
        {"wrapper": wrappers.ReshapeObservation, "shape": (2, SIZE // 2)},
    ),
    "VectorizeTransformReward": (several, {"wrapper": wrappers.TransformReward, "func": np.negative}),
}
NOT_FOR_THESE = {
    "AtariPreprocessing": "reads the memory of an Atari game",
    "HumanRendering": "opens a window; the environments have the render mode `human` of their own",
    "JaxToNumpy": "is for environments in JAX",
    "JaxToTorch": "is for environments in JAX",
    "vector": "is the module of the wrappers for vectors",
}
PACKAGES = {
    "ArrayConversion": "array_api_compat",
    "NumpyToTorch": "array_api_compat",
    "RecordVideo": "moviepy",
    "ResizeObservation": "cv2",
}
"""Package that a wrapper needs beside those that the suite's tests install."""


LESS_PRECISE = pytest.mark.filterwarnings("ignore:.*precision lowered by casting")
"""What Gymnasium says of observations in single precision."""


@pytest.mark.parametrize(("module", "tried"), [(wrappers, SINGLE), (vector, TOGETHER)])
def test_none_is_left_out(module: Any, tried: dict[str, Any]) -> None:
    assert set(module.__all__) - set(tried) <= set(NOT_FOR_THESE)
    assert set(tried) <= set(module.__all__)
    assert not set(tried) & set(NOT_FOR_THESE)


def wrapped(module: Any, name: str, make: Make, keywords: dict[str, Any]) -> Any:
    if name in PACKAGES:
        pytest.importorskip(PACKAGES[name])
    return getattr(module, name)(make(), **keywords)


@LESS_PRECISE
@pytest.mark.parametrize("name", SINGLE)
def test_wrapped_environment_runs_an_episode(
    name: str, open_contexts: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    env = wrapped(wrappers, name, *SINGLE[name])
    env.action_space.seed(0)
    observation, start = env.reset(seed=0)
    truncated = False
    for _ in range(STEPS):
        if not truncated:
            assert isinstance(observation, np.ndarray | dict) == (name != "NumpyToTorch")
            if name != "NumpyToTorch":
                assert env.observation_space.contains(observation)
            observation, reward, terminated, truncated, info = env.step(env.action_space.sample())
    assert truncated
    assert not terminated
    assert np.isfinite(float(reward))
    assert set(start) <= set(info)
    assert isinstance(env.unwrapped, PRPEnv)
    assert env.spec is not None
    assert env.spec.max_episode_steps == (4 if name == "TimeLimit" else STEPS)
    env.close()


@LESS_PRECISE
@pytest.mark.parametrize("name", TOGETHER)
def test_wrapped_environments_run_an_episode(
    name: str, open_contexts: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    env = wrapped(vector, name, *TOGETHER[name])
    env.action_space.seed(0)
    observation, _ = env.reset(seed=0)
    for _ in range(STEPS):
        if name != "NumpyToTorch":
            assert env.observation_space.contains(observation)
        observation, reward, terminated, truncated, _ = env.step(env.action_space.sample())
        assert np.isfinite(np.asarray(reward)).all()
    assert np.asarray(truncated).all()
    assert not np.asarray(terminated).any()
    env.step(env.action_space.sample())
    env.close()
