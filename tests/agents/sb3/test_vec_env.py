"""The adapter for Stable-Baselines3 is its DummyVecEnv of single environments, bit for bit."""

import copy
from collections.abc import Callable, Sequence
from functools import partial
from operator import attrgetter, methodcaller
from typing import Any

import gymnasium
import numpy as np
import pytest
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import (
    DummyVecEnv,
    VecCheckNan,
    VecEnv,
    VecFrameStack,
    VecMonitor,
    VecNormalize,
)

import prp_gym
from prp_gym.errors import (
    EpisodeError,
    JointLimitError,
    NonFiniteError,
    PRPError,
    ShapeError,
    UnknownNameError,
)
from tests.support.sb3_environments import (
    ID,
    SHORT,
    N,
    actions_for,
    assert_same,
    assert_same_episodes,
    assert_same_results,
    both,
    together,
)

IDS = prp_gym.list_envs()


@pytest.mark.parametrize("scenario", ["report", "randomized", "realistic"])
@pytest.mark.parametrize("environment_id", IDS)
def test_steps_and_episode_ends_are_those_of_single_environments(environment_id: str, scenario: str) -> None:
    ours, theirs = both(environment_id, scenario=scenario)
    steps = assert_same_episodes(ours, theirs, actions_for(ours, 20, (0.01,) * N))
    dones = np.array([done for _, _, done, _ in steps])
    np.testing.assert_array_equal(np.flatnonzero(dones.all(axis=1)), [5, 11, 17])
    assert all(info["TimeLimit.truncated"] for info in steps[5][3])


@pytest.mark.parametrize("environment_id", [name for name in IDS if name != "PRP-Adaptive-v0"])
def test_diverged_environments_begin_anew_alone(environment_id: str) -> None:
    ours, theirs = both(environment_id, scenario="report")
    steps = assert_same_episodes(ours, theirs, actions_for(ours, 20, (1.0, 1e-6, 0.2, 1.0)))
    dones = np.array([done for _, _, done, _ in steps])
    assert (dones.any(axis=1) & ~dones.all(axis=1)).any()
    ended = [info for _, _, done, infos in steps for info in np.array(infos)[done]]
    assert {info["TimeLimit.truncated"] for info in ended} == {True, False}
    assert all("terminal_observation" in info for info in ended)


def test_link_that_diverges_begins_anew_alone() -> None:
    ours, theirs = both("PRP-Adaptive-v0", scenario="report", duration=1.0)
    actions = [np.array([[1.0], [0.0], [-1.0], [0.0]], dtype=np.float32)] * 60
    dones = np.array([done for _, _, done, _ in assert_same_episodes(ours, theirs, actions)])
    assert (dones.any(axis=1) & ~dones.all(axis=1)).any()


def test_nothing_returned_changes_later() -> None:
    env = together()
    env.seed(7)
    returned: list[Any] = [env.reset()]
    copies = copy.deepcopy(returned)
    env.reset_infos[1]["time"] = 9.0
    for action in actions_for(env, 7):
        env.step_async(action)
        returned.append(env.step_wait())
        copies.append(copy.deepcopy(returned[-1]))
    assert_same(returned, copies, "after seven steps")
    assert [info["time"] for info in env.reset_infos] == [0.0] * N  # what was written there is gone
    observation, _, done, infos = returned[6]
    assert done.all()
    for info in infos:
        info["terminal_observation"] += 1.0
    np.testing.assert_array_equal(observation, copies[6][0])


@pytest.mark.parametrize(
    "wrapped",
    [VecNormalize, VecCheckNan, VecMonitor, partial(VecFrameStack, n_stack=3)],
    ids=["VecNormalize", "VecCheckNan", "VecMonitor", "VecFrameStack"],
)
def test_wrappers_of_stable_baselines_do_the_same(
    wrapped: Callable[[VecEnv], VecEnv], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("time.time", lambda: 0.0)  # VecMonitor's "t"
    ours, theirs = both()
    assert_same_episodes(wrapped(ours), wrapped(theirs), actions_for(ours, 20))


def test_episode_statistics_are_those_of_single_monitors() -> None:
    ours = prp_gym.make_sb3_vec_env(ID, N, **SHORT)
    theirs = DummyVecEnv([lambda: Monitor(gymnasium.make(ID, **SHORT))] * N)
    statistics: list[list[Any]] = []
    for env in (ours, theirs):
        env.seed(3)
        env.reset()
        infos = [env.step(action)[3] for action in actions_for(env, 13)]
        statistics.append([item["episode"] for step in infos for item in step if "episode" in item])
    assert len(statistics[0]) == 2 * N
    assert [found["l"] for found in statistics[0]] == [expected["l"] for expected in statistics[1]]
    returns = [[float(episode["r"]) for episode in episodes] for episodes in statistics]
    # six rewards of at most 0.01 s in float32, and Monitor rounds to 1e-6
    np.testing.assert_allclose(returns[0], returns[1], rtol=0, atol=6e-7)


def test_seeds_and_options_are_used_once() -> None:
    envs = both()
    for env in envs:
        assert env.seed(5) == [5, 6, 7, 8]
        env.set_options({"goal": np.array([0.4, -0.1, 0.2])})
    first: list[Any] = [env.reset() for env in envs]
    plain: list[Any] = [env.reset() for env in envs]
    assert_same(first[0], first[1], "seeded, with a goal")
    assert_same(plain[0], plain[1], "neither")
    assert not np.array_equal(first[0], plain[0])
    assert_same_results(envs, attrgetter("reset_infos"), "reset infos")
    envs[0].seed(5)
    envs[0].set_options({"goal": np.array([0.4, -0.1, 0.2])})
    assert_same(envs[0].reset(), first[0], "the same seed again")


@pytest.mark.parametrize("seeds", [(5,), (5, 6), (5, None)])
def test_environments_may_have_different_options(seeds: Sequence[int | None]) -> None:
    envs = both(scenario="realistic")
    start, goal = np.array([0.3, -0.2, 0.1]), np.array([0.4, -0.1, 0.2])
    for env in envs:
        for seed in seeds[:-1]:
            env.seed(seed)
            env.reset()
        if seeds[-1] is not None:
            env.seed(seeds[-1])
        env.set_options([{"goal": goal}, {}, {"joint_position": start, "goal": goal}, {"goal": start}])
    assert_same_results(envs, methodcaller("reset"), "reset")
    for count, action in enumerate(actions_for(envs[0], 13)):
        assert_same_results(envs, methodcaller("step", action), f"step {count}")


def test_environments_without_seeds_may_have_different_options() -> None:
    env = together()
    goal = np.array([0.4, -0.1, 0.2])
    env.set_options([{"goal": goal}, {}, {}, {}])
    desired = env.together.observation_layout.split(env.reset())["desired_joint_position"]
    np.testing.assert_array_equal((desired == goal).all(axis=1), [True, False, False, False])


@pytest.mark.parametrize(
    ("options", "error"),
    [
        ([{}] * (N - 1), ShapeError),
        ([{}, {"goals": np.zeros(3)}, {}, {}], UnknownNameError),
        ({"reset_mask": np.ones(N, dtype=np.bool_)}, UnknownNameError),
        ({"goal": np.zeros((N, 3))}, ShapeError),
        ({"goal": [0.0, np.nan, 0.0]}, NonFiniteError),
        ([{}, {}, {"goal": [0.0, 0.5, 0.0]}, {}], JointLimitError),
    ],
)
def test_options_that_a_task_does_not_take_are_refused(options: Any, error: type[PRPError]) -> None:
    env = together()
    env.reset()
    env.set_options(options)
    with pytest.raises(error):
        env.reset()


def test_actions_of_another_shape_or_before_an_episode_are_refused() -> None:
    env = together()
    with pytest.raises(EpisodeError):
        env.step(np.zeros((N, 3)))
    env.reset()
    with pytest.raises(ShapeError):
        env.step(np.zeros((N, 2)))
    with pytest.raises(NonFiniteError):
        env.step(np.full((N, 3), np.nan))
