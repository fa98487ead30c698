"""`record_episodes`: many episodes at once are those that the environment runs one by one."""

from dataclasses import fields, replace
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.wrappers import FrameStackObservation, RecordEpisodeStatistics, RescaleAction, TimeLimit

from prp_gym import evaluate
from prp_gym.baselines import BASELINES, make_baseline
from prp_gym.baselines.base.gains import load_gains
from prp_gym.errors import InvalidValueError
from prp_gym.evaluation import Rollout, record_episode
from prp_gym.evaluation.batch import can_batch, record_episodes
from tests.support.controller_episodes import COMBINATIONS, make

TRACKING = "PRP-JointTracking-v0"
HOME = {
    controller: next(name for name, other in reversed(COMBINATIONS) if other == controller)
    for controller in BASELINES
}


def assert_same(first: Rollout, second: Rollout) -> None:
    """Equal bits, but for the time that the policy took."""
    for entry in fields(Rollout):
        one, other = getattr(first, entry.name), getattr(second, entry.name)
        if isinstance(one, dict):
            assert set(one) == set(other)
            for name, values in one.items():
                np.testing.assert_array_equal(values, other[name], err_msg=name)
                assert values.dtype == other[name].dtype
        elif entry.name != "compute_time":
            np.testing.assert_array_equal(one, other, err_msg=entry.name)
            assert type(one) is type(other)


class Spy:
    """A policy that records how many observations it got at a time, and passes them on."""

    def __init__(self, policy: Any) -> None:
        self.policy = policy
        self.shapes: list[tuple[int, ...]] = []

    def predict(self, observation: Any, *rest: Any, **flags: Any) -> Any:
        self.shapes.append(np.shape(observation))
        return self.policy.predict(observation, *rest, **flags)


class Runaway:
    """Pushes joint 3 the way it turns in episodes that start with q_1 > 0, and rests in the others.

    Its state is which of the episodes those are.
    """

    def __init__(self, env: Any) -> None:
        self.layout = env.get_wrapper_attr("observation_layout")

    def predict(
        self, observation: Any, state: Any = None, episode_start: Any = None, deterministic: bool = True
    ) -> Any:
        parts = self.layout.split(observation)
        mad = (parts["joint_position"][..., :1] > 0.0).astype(np.float64)
        if state is not None:
            again = (
                np.reshape(episode_start, (-1, *([1] * (mad.ndim - 1)))) if mad.ndim > 1 else episode_start
            )
            mad = np.where(again, mad, state[0])
        action = np.zeros(parts["joint_velocity"].shape, dtype=np.float32)
        action[..., 2] = np.where(parts["joint_velocity"][..., 2] < 0.0, -1.0, 1.0) * mad[..., 0]
        return action, (mad,)


@pytest.mark.parametrize("controller", BASELINES)
def test_episodes_at_once_are_those_run_one_by_one(controller: str) -> None:
    env = make(HOME[controller], scenario="realistic", duration=0.3)
    policy, seeds = make_baseline(controller, env), (4, 17, 2, 9)
    together = record_episodes(policy, env, seeds)
    assert [rollout.seed for rollout in together] == list(seeds)
    for seed, rollout in zip(seeds, together, strict=True):
        assert_same(rollout, record_episode(policy, env, seed))
        assert len(rollout.reward) == 150
    starts = {rollout.fields["joint_position"][0].tobytes() for rollout in together}
    assert len(starts) == len(seeds)
    env.close()


def test_link_s_episodes_at_once_are_those_run_one_by_one() -> None:
    env = make("PRP-Adaptive-v0", scenario="realistic", duration=0.6)
    policy = make_baseline("adaptive", env)
    for seed, rollout in enumerate(record_episodes(policy, env, range(4))):
        assert_same(rollout, record_episode(policy, env, seed))


def test_episode_that_diverges_ends_there_and_leaves_its_neighbours_alone() -> None:
    env = make(TRACKING, scenario="realistic", duration=0.6, torque_limit=(50.0, 100.0, 500.0))
    policy = Runaway(env)
    together = record_episodes(policy, env, range(8))
    for seed, rollout in enumerate(together):
        assert_same(rollout, record_episode(policy, env, seed))
        mad = rollout.fields["joint_position"][0, 0] > 0.0
        assert rollout.diverged == mad
        length = len(rollout.reward)
        assert (length < 300) == mad
        assert {len(values) for values in rollout.info.values()} == {length}
        assert {len(values) for values in rollout.fields.values()} == {length + 1}
        if mad:
            assert rollout.reward[-1] == 0.0
    assert 2 <= sum(rollout.diverged for rollout in together) <= 6
    env.close()


@pytest.mark.parametrize(("controller", "gains"), [("joint_pd", "figures"), ("adaptive", "report")])
def test_controller_whose_gains_are_unstable_diverges_alike_at_once_and_alone(
    controller: str, gains: str
) -> None:
    limit = (5e3, 1e4, 1e3)  # with the nominal limits and stops the unstable arm only rattles
    env = make(TRACKING, scenario="realistic", duration=2.0, control_frequency=50, torque_limit=limit)
    numbers = load_gains(controller, gains, TRACKING)
    # with all gains given, any control frequency is allowed
    own = {name: numbers[name] for name in BASELINES[controller].settings_class.vectors}
    policy = make_baseline(controller, env, gains, **own)
    together = record_episodes(policy, env, range(6))
    assert sum(rollout.diverged for rollout in together) >= 5
    assert len({len(rollout.reward) for rollout in together}) >= 4  # others go on when the first has ended
    for seed, rollout in enumerate(together):
        assert_same(rollout, record_episode(policy, env, seed))
    env.close()


def test_policy_is_told_where_an_episode_starts_anew_after_a_divergence() -> None:
    env = make(TRACKING, scenario="realistic", duration=0.6, torque_limit=(50.0, 100.0, 500.0))
    policy, told = Runaway(env), []

    class Listener:
        def predict(
            self, observation: Any, state: Any = None, episode_start: Any = None, deterministic: bool = True
        ) -> Any:
            if np.ndim(observation) == 2:
                told.append(np.array(episode_start))
            return policy.predict(observation, state, episode_start)

    rollouts = record_episodes(Listener(), env, range(8))
    flags = np.array(told)
    assert flags[0].all()
    for row, rollout in enumerate(rollouts):
        starts = np.flatnonzero(flags[:, row])
        assert rollout.diverged == (len(starts) > 1)
        if rollout.diverged:
            assert starts[1] == len(rollout.reward)
    env.close()


def test_later_episodes_of_a_row_that_diverged_leave_no_trace() -> None:
    env = make(TRACKING, scenario="realistic", duration=0.3, torque_limit=(50.0, 100.0, 500.0))
    policy = Runaway(env)
    short = record_episodes(policy, env, range(8))
    env.close()
    env = make(TRACKING, scenario="realistic", duration=0.6, torque_limit=(50.0, 100.0, 500.0))
    for early, late in zip(short, record_episodes(policy, env, range(8)), strict=True):
        if early.diverged:
            assert_same(replace(early, duration=0.6), late)
    assert any(rollout.diverged for rollout in short)
    env.close()


def test_policy_acts_on_all_observations_and_is_timed_on_one() -> None:
    env = make(TRACKING, duration=1.0, scenario="randomized")
    spy = Spy(make_baseline("joint_pd", env))
    size = env.observation_space.shape[0]
    rollouts = record_episodes(spy, env, range(5))
    assert spy.shapes.count((5, size)) == 500
    assert spy.shapes.count((size,)) == len(rollouts[0].compute_time) == 64
    assert spy.shapes[:2] == [(size,), (5, size)]
    for rollout in rollouts:
        assert (rollout.compute_time > 0.0).all()
    env.close()


def test_short_episodes_are_timed_at_every_step() -> None:
    env = make(TRACKING, duration=0.04, scenario="randomized")
    spy = Spy(make_baseline("adaptive", env))
    rollouts = record_episodes(spy, env, range(3))
    assert len(spy.shapes) == 2 * 20
    assert {len(rollout.compute_time) for rollout in rollouts} == {20}
    alone = record_episode(make_baseline("adaptive", env), env, 1)
    assert alone.compute_time.shape == (20,)
    assert_same(rollouts[1], alone)  # to be timed changes nothing
    env.close()


def test_only_what_wraps_without_changing_is_passed_over() -> None:
    env = make(TRACKING)
    assert can_batch(env)
    assert can_batch(env.unwrapped)
    assert can_batch(gymnasium.make(TRACKING, disable_env_checker=True))
    low = np.full(3, -2.0, dtype=np.float32)
    for wrapped in (
        RescaleAction(env, low, -low),
        RecordEpisodeStatistics(env),
        FrameStackObservation(env, 2),
        TimeLimit(env, 10),
        make(TRACKING, max_episode_steps=10),
    ):
        assert not can_batch(wrapped)
    assert not can_batch(gymnasium.make("CartPole-v1"))


@pytest.mark.parametrize("limit", [1.0, 2.0])
def test_episodes_behind_a_wrapper_that_rescales_are_run_one_by_one(limit: float) -> None:
    plain = make(TRACKING, scenario="randomized", duration=0.1)
    bound = np.full(3, limit, dtype=np.float32)
    env = RescaleAction(make(TRACKING, scenario="randomized", duration=0.1), -bound, bound)
    spy = Spy(make_baseline("joint_pd", env))
    evaluation = evaluate(spy, env, episodes=3, seed=2)
    assert set(spy.shapes) == {env.observation_space.shape}
    for rollout, other in zip(
        evaluation.rollouts, evaluate(spy.policy, plain, episodes=3, seed=2).rollouts, strict=True
    ):
        # half of the action is the torque's half
        first = rollout.torque[0] * limit
        np.testing.assert_allclose(first, other.torque[0], rtol=1e-6)  # float32
        assert len(rollout.compute_time) == 50


def test_one_episode_is_run_alone() -> None:
    env = make(TRACKING, scenario="randomized", duration=0.1)
    spy = Spy(make_baseline("joint_pd", env))
    evaluate(spy, env, episodes=1, seed=0)
    assert set(spy.shapes) == {env.observation_space.shape}
    env.close()


def test_environment_of_another_suite_is_refused() -> None:
    foreign = gymnasium.make("CartPole-v1")
    policy = make_baseline("joint_pd", make(TRACKING))
    with pytest.raises(InvalidValueError, match="an environment of prp_gym"):
        record_episodes(policy, foreign, range(2))
    foreign.close()
