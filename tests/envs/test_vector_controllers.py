"""Controllers on many environments: the actions of single ones, and episodes through autoreset."""

from typing import Any

import numpy as np
import pytest

from prp_gym.baselines import list_baselines, make_baseline
from prp_gym.robot.arrays import Array
from tests.support.controller_episodes import COVERING
from tests.support.vector_episodes import actions_for, single, together

N = 3
BRIEF: dict[str, Any] = {"scenario": "realistic", "duration": 0.1}  # 50 steps
FORCE, CONTROLLER = "PRP-Force-v0", "force_inner_position"
# products of matrices may round differently one by one: actions are of single precision
ROUNDING = 1e-6


@pytest.mark.parametrize(("environment_id", "controller"), COVERING, ids=map("-".join, COVERING))
def test_controller_of_many_environments_acts_as_those_of_single_ones(
    environment_id: str, controller: str
) -> None:
    env, alone = together(environment_id, num_envs=N, **BRIEF), single(environment_id, **BRIEF)
    assert controller in list_baselines(env.observation_layout)
    ours, theirs = make_baseline(controller, env), make_baseline(controller, alone)
    assert repr(ours.settings) == repr(theirs.settings)
    observation, _ = env.reset(seed=6)
    state: Any = None
    own: list[Any] = [None] * N
    start = np.ones(N, dtype=np.bool_)
    for action in actions_for(env, 5):
        found, state = ours.predict(observation, state, start)
        assert found.shape == env.action_space.shape
        assert env.action_space.contains(found)
        for index in range(N):
            expected, own[index] = theirs.predict(observation[index], own[index], start[:1])
            np.testing.assert_allclose(found[index], expected, ROUNDING, ROUNDING)
        observation, start = env.step(action)[0], np.zeros(N, dtype=np.bool_)


def returns_together(mode: str, episodes: int, resets_state: bool = True) -> Array:
    """Returns (episodes, N) of successive episodes; the controller's state is reset with each, or never."""
    env = together(FORCE, mode, N, **BRIEF)
    policy = make_baseline(CONTROLLER, env)
    observation, _ = env.reset(seed=6)
    state, start = None, np.ones(N, dtype=np.bool_)
    done: list[list[float]] = [[] for _ in range(N)]
    total = np.zeros(N)
    while min(len(own) for own in done) < episodes:
        action, state = policy.predict(observation, state, start)
        observation, reward, terminated, truncated, info = env.step(action)
        total += reward
        ended = terminated | truncated
        for index in np.flatnonzero(ended):
            done[index].append(float(total[index]))
        total[ended] = 0.0
        # an episode starts with this observation: its time is 0, in whichever step that is
        start = info["_time"] & (info["time"] == 0.0) & resets_state
    return np.array([own[:episodes] for own in done]).T


def returns_alone(episodes: int) -> Array:
    returns = np.zeros((episodes, N))
    for index in range(N):
        env = single(FORCE, **BRIEF)
        policy = make_baseline(CONTROLLER, env)
        for episode in range(episodes):
            observation, _ = env.reset(seed=6 + index if episode == 0 else None)
            state, start, truncated = None, np.array([True]), False
            while not truncated:
                action, state = policy.predict(observation, state, start)
                observation, reward, terminated, truncated, _ = env.step(action)
                assert not terminated
                returns[episode, index] += reward
                start = np.array([False])
    return returns


@pytest.mark.parametrize("mode", ["NextStep", "SameStep"])
def test_episodes_of_a_stateful_controller_with_autoreset_equal_separate_ones(mode: str) -> None:
    found, expected = returns_together(mode, 3), returns_alone(3)
    assert len(np.unique(expected)) == 3 * N
    # what rounds differently in the controller's products, 1e-7 of an action, over 50 steps in contact
    np.testing.assert_allclose(found, expected, rtol=1e-5)


def test_controller_that_is_never_reset_gives_other_episodes() -> None:
    """This shows that the comparison above depends on the controller's state."""
    found, expected = returns_together("NextStep", 2, resets_state=False), returns_together("NextStep", 2)
    np.testing.assert_array_equal(found[0], expected[0])
    assert (np.abs(found[1] / expected[1] - 1.0) > 1e-4).any()


def test_observations_that_start_episodes_are_recognised_by_their_time_in_every_mode() -> None:
    for mode, expected in (("NextStep", [50, 101]), ("SameStep", [49, 99])):
        env = together(FORCE, mode, N, **BRIEF)
        env.reset(seed=0)
        starts = []
        for count in range(110):
            info = env.step(np.zeros((N, 3)))[4]
            if (info["_time"] & (info["time"] == 0.0)).all():
                starts.append(count)
        assert starts == expected
