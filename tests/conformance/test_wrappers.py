"""The environments under the wrappers and vectors of Gymnasium and Stable-Baselines3."""

import os
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.wrappers import (
    FrameStackObservation,
    NormalizeObservation,
    RecordEpisodeStatistics,
    RecordVideo,
    RescaleAction,
    TimeLimit,
)
from stable_baselines3 import PPO
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import DummyVecEnv

import prp_gym

Env = gymnasium.Env[Any, Any]
RATE = 50
DURATION = 0.5
STEPS = round(RATE * DURATION)


@pytest.fixture(scope="module")
def filming(open_contexts: None) -> None:
    """Skip where no film can be made, unless that must not be."""
    if find_spec("moviepy") is None:
        if os.environ.get("PRP_REQUIRE_RENDERING") == "1":
            pytest.fail("PRP_REQUIRE_RENDERING=1, but moviepy is not installed")
        pytest.skip("moviepy is not installed")


@pytest.fixture(params=prp_gym.list_envs())
def environment_id(request: pytest.FixtureRequest) -> str:
    return str(request.param)


def made(environment_id: str, **keywords: Any) -> Env:
    return gymnasium.make(environment_id, control_frequency=RATE, duration=DURATION, **keywords)


def joints(env: Env) -> int:
    return int(np.prod(env.action_space.shape or ()))


def actions(env: Env, seed: int = 0) -> Any:
    return np.random.default_rng(seed).uniform(-1.0, 1.0, size=(STEPS, joints(env))).astype(np.float32)


def test_episode_statistics_are_those_of_the_episode(environment_id: str) -> None:
    env = RecordEpisodeStatistics(made(environment_id))
    env.reset(seed=0)
    rewards, infos = [], []
    for action in actions(env):
        _, reward, terminated, truncated, info = env.step(action)
        rewards.append(float(reward))
        infos.append(info)
    assert (terminated, truncated) == (False, True)
    assert not any("episode" in info for info in infos[:-1])
    assert infos[-1]["episode"]["l"] == STEPS
    # the wrapper may round its sum
    assert infos[-1]["episode"]["r"] == pytest.approx(sum(rewards), rel=1e-6)


def test_rescaled_actions_act_as_the_originals(environment_id: str) -> None:
    plain = made(environment_id)
    limit = np.full(joints(plain), 5.0, dtype=np.float32)
    rescaled = RescaleAction(made(environment_id), -limit, limit)
    plain.reset(seed=0)
    rescaled.reset(seed=0)
    for action in actions(plain):
        expected, found = plain.step(action)[0], rescaled.step(5.0 * action)[0]
        # actions in single precision: 1e-7 relative, grown by the arm's motion over half a second
        np.testing.assert_allclose(found, expected, rtol=1e-3, atol=1e-3)


def test_shorter_time_limit_truncates_earlier(environment_id: str) -> None:
    env = TimeLimit(made(environment_id), max_episode_steps=7)
    env.reset(seed=0)
    flags = [env.step(action)[2:4] for action in actions(env)[:7]]
    assert flags == [(False, False)] * 6 + [(False, True)]


def test_time_limit_of_make_is_honoured(environment_id: str) -> None:
    env = made(environment_id, max_episode_steps=3)
    env.reset(seed=0)
    assert [env.step(action)[3] for action in actions(env)[:3]] == [False, False, True]


def test_stacked_frames_are_the_last_observations(environment_id: str) -> None:
    plain, stacked = made(environment_id), FrameStackObservation(made(environment_id), 3)
    frames = [plain.reset(seed=0)[0]]
    stack, _ = stacked.reset(seed=0)
    np.testing.assert_array_equal(stack, np.stack([frames[0]] * 3))
    for action in actions(plain):
        frames.append(plain.step(action)[0])
        stack = stacked.step(action)[0]
        if len(frames) >= 3:
            np.testing.assert_array_equal(stack, np.stack(frames[-3:]))


def test_observations_can_be_normalized(environment_id: str) -> None:
    env = NormalizeObservation(made(environment_id))
    seen = []
    for episode in range(8):
        seen.append(env.reset(seed=episode)[0])
        seen += [env.step(action)[0] for action in actions(env, episode)]
    values = np.array(seen)
    assert np.isfinite(values).all()
    # running mean and variance, so only roughly: within some standard deviations
    assert (np.abs(values[len(values) // 2 :].mean(axis=0)) < 2.0).all()
    assert np.abs(values).max() < 50.0


@pytest.mark.parametrize("environment_id", ["PRP-Adaptive-v0", "PRP-ForcePosition-v0"])
def test_film_of_an_episode_is_written(filming: None, environment_id: str, tmp_path: Path) -> None:
    """Of the link and of the arm; the checkers of `test_environments.py` look at the frames of all."""
    folder = tmp_path / "films"
    env: Env = RecordVideo(
        made(environment_id, render_mode="rgb_array", width=64, height=64),
        str(folder),
        episode_trigger=lambda episode: episode == 0,
        disable_logger=True,
    )
    env.reset(seed=0)
    for action in actions(env):
        env.step(action)
    env.close()
    films = list(folder.glob("*.mp4"))
    assert len(films) == 1
    assert films[0].stat().st_size > 500  # an empty container is smaller


def test_synchronous_vector_equals_its_environments(environment_id: str) -> None:
    vector = gymnasium.vector.SyncVectorEnv([lambda: made(environment_id) for _ in range(3)])
    singles = [made(environment_id) for _ in range(3)]
    observations, _ = vector.reset(seed=5)
    expected = [env.reset(seed=5 + index)[0] for index, env in enumerate(singles)]
    np.testing.assert_array_equal(observations, expected)
    for action in actions(singles[0]):
        batch = np.stack([action, -action, 0.5 * action])
        observations, rewards, terminated, truncated, infos = vector.step(batch)
        outcomes = [env.step(row) for env, row in zip(singles, batch, strict=True)]
        np.testing.assert_array_equal(observations, [outcome[0] for outcome in outcomes])
        np.testing.assert_array_equal(rewards, [outcome[1] for outcome in outcomes])
        np.testing.assert_array_equal(infos["time"], [outcome[4]["time"] for outcome in outcomes])
    assert truncated.all()
    assert not terminated.any()
    vector.close()


def test_vector_of_make_vec_goes_on_after_an_episode(environment_id: str) -> None:
    vector = gymnasium.make_vec(
        environment_id, num_envs=2, control_frequency=RATE, duration=DURATION, vectorization_mode="sync"
    )
    vector.reset(seed=0)
    ends = [
        vector.step(np.zeros(vector.action_space.shape or (), dtype=np.float32))[3]
        for _ in range(2 * STEPS + 2)
    ]
    # with autoreset in the next step an episode takes one more
    np.testing.assert_array_equal(np.flatnonzero([end.all() for end in ends]), [STEPS - 1, 2 * STEPS])
    vector.close()


def test_monitor_reports_return_and_length(environment_id: str) -> None:
    env = Monitor(made(environment_id))
    env.reset(seed=0)
    rewards = []
    for action in actions(env):
        _, reward, _, _, info = env.step(action)
        rewards.append(float(reward))
    assert info["episode"]["l"] == STEPS
    assert info["episode"]["r"] == pytest.approx(sum(rewards), abs=1e-6)  # Monitor rounds to 6 digits


def test_ppo_learns_a_little_in_a_vector(environment_id: str) -> None:
    vector = DummyVecEnv([lambda: Monitor(made(environment_id)) for _ in range(2)])
    agent = PPO("MlpPolicy", vector, n_steps=64, batch_size=64, n_epochs=1, seed=0, device="cpu")
    before = [parameter.detach().clone() for parameter in agent.policy.parameters()]
    agent.learn(256)
    assert agent.num_timesteps == 256
    after = list(agent.policy.parameters())
    assert any(bool((old != new).any()) for old, new in zip(before, after, strict=True))
    assert all(bool(new.isfinite().all()) for new in after)
    assert len(agent.ep_info_buffer or ()) == 2 * (128 // STEPS)
    observation = vector.reset()
    assert isinstance(observation, np.ndarray)
    action, _ = agent.predict(observation, deterministic=True)
    assert action.shape == (2, *(vector.action_space.shape or ()))
    vector.close()
