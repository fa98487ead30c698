"""Every controller on every kind of environment: at once as one by one, restarts, SB3's evaluator."""

from functools import partial
from typing import Any

import numpy as np
import pytest
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import DummyVecEnv

from prp_gym.baselines import make_baseline
from prp_gym.evaluation import evaluate
from tests.support.controller_episodes import COVERING, Array, make, observed_episodes

EPISODES, STEPS = 4, 20
# products of matrices and least squares may round differently one by one: some dozen operations of 1e-16
ROUNDING = 1e-12

everywhere = pytest.mark.parametrize(("environment_id", "controller"), COVERING, ids=map("-".join, COVERING))


def assert_near(found: Array, expected: Array, scale: Array, rounding: float = ROUNDING) -> None:
    """Equal to rounding of each component, or of numbers of its size over the episodes where it cancels."""
    atol = rounding * np.abs(scale).max(axis=tuple(range(scale.ndim - 1)))
    assert found.shape == expected.shape
    assert (np.abs(found - expected) <= ROUNDING * np.abs(expected) + atol).all(), (found, expected)


@everywhere
def test_episodes_side_by_side_are_controlled_as_each_on_its_own(
    environment_id: str, controller: str
) -> None:
    policy, episodes = observed_episodes(environment_id, controller, EPISODES, STEPS)
    split = policy.interface.layout.split
    state, torques, states = policy.initial_state(split(episodes[0])), [], []
    for observation in episodes:
        torque, state = policy.control(split(observation), state)
        torques.append(torque)
        states.append(state)
    scale = np.array(torques)
    assert np.ptp(scale, axis=(0, 1)).min() > 0.0  # the episodes differ
    # J_A⁺ makes more of the roundings where the arm is nearly singular
    rounding = 10.0 * ROUNDING if "end_effector_pose" in policy.measured_fields else ROUNDING
    parts = [np.array(part) for part in zip(*states, strict=True)]
    for row in range(EPISODES):
        own, alone, kept = policy.initial_state(split(episodes[0, row])), [], []
        for observation in episodes[:, row]:
            torque, own = policy.control(split(observation), own)
            alone.append(torque)
            kept.append(own)
        assert_near(np.array(alone), scale[:, row], scale, rounding)
        for single, together in zip(zip(*kept, strict=True), parts, strict=True):
            for index, part in enumerate(together):  # a state may grow, so that each step has its own scale
                assert_near(single[index], part[row], part)


@everywhere
def test_state_starts_anew_only_where_an_episode_starts(environment_id: str, controller: str) -> None:
    policy, episodes = observed_episodes(environment_id, controller, EPISODES, STEPS)
    before, after = episodes[:10, :3], episodes[10:, :3]
    state: Any = None
    for observation in before:
        _, state = policy.predict(observation, state, np.zeros(3, dtype=np.bool_))
    going, mixed, fresh = state, state, None
    restart = np.array([False, True, False])
    begun = policy.initial_state(policy.interface.layout.split(after[0]))
    is_stateful = any((old != new)[1].any() for old, new in zip(state or (), begun, strict=True))
    for index, observation in enumerate(after):
        flags = restart if index == 0 else np.zeros(3, dtype=np.bool_)
        kept, going = policy.predict(observation, going, np.zeros(3, dtype=np.bool_))
        action, mixed = policy.predict(observation, mixed, flags)
        new, fresh = policy.predict(observation, fresh, None)
        np.testing.assert_array_equal(action, np.where(restart[:, None], new, kept))
        for part, old, anew in zip(mixed or (), going or (), fresh or (), strict=True):
            np.testing.assert_array_equal(part, np.where(restart[:, None], anew, old))
        if is_stateful and index == 0:  # to start anew makes a difference
            assert any((old != anew)[1].any() for old, anew in zip(going or (), fresh or (), strict=True))
    # the state of a force controller off the surface is still the initial one
    assert is_stateful == (state is not None) or controller == "parallel_force_position"


def returns_in_a_row(env: Any, policy: Any, seed: int) -> list[float]:
    """Returns of an episode with a seed, and of the one after it, which goes on with the env's generator."""
    returns = []
    for own in (seed, None):
        observation, _ = env.reset(seed=own)
        state, start, truncated, total = None, np.array([True]), False, 0.0
        while not truncated:
            action, state = policy.predict(observation, state, start)
            observation, reward, terminated, truncated, _ = env.step(action)
            start, total = np.array([False]), total + reward
            assert not terminated
        returns.append(total)
    return returns


@everywhere
def test_evaluator_of_stable_baselines_runs_the_same_episodes(environment_id: str, controller: str) -> None:
    """`VecEnv.seed(s)` seeds the first reset of the i-th environment with s + i; later resets go on from it.

    A single environment is put into a vector of one by the evaluator, which seeds nothing: the generator of
    an environment that was reset with a seed goes on.
    """
    single = partial(make, environment_id, scenario="randomized", duration=0.05)
    env = single()
    policy: Any = make_baseline(controller, env)
    in_a_row = np.array([returns_in_a_row(env, policy, seed) for seed in (11, 12, 13)])
    ours = [rollout.reward.sum() for rollout in evaluate(policy, env, episodes=3, seed=11).rollouts]
    np.testing.assert_allclose(in_a_row[:, 0], ours, rtol=1e-14)  # sums in another order
    vector = DummyVecEnv([single] * 3)
    vector.seed(11)
    returns, lengths = evaluate_policy(policy, vector, 6, return_episode_rewards=True, warn=False)
    assert lengths == [25] * 6
    # rewards are float32 in a DummyVecEnv: 25 of at most 1, each rounded to 6e-8 of itself
    np.testing.assert_allclose(returns, in_a_row.T.ravel(), rtol=0, atol=2e-6)
    monitored = Monitor(single())
    monitored.reset(seed=11)
    state = monitored.unwrapped.np_random.bit_generator.state
    mean, _ = evaluate_policy(policy, monitored, n_eval_episodes=1)
    monitored.unwrapped.np_random.bit_generator.state = state
    again, _ = evaluate_policy(policy, monitored, n_eval_episodes=1)
    assert mean == again == pytest.approx(in_a_row[0, 1], abs=1e-6)  # Monitor rounds to 1e-6
    env.close()
