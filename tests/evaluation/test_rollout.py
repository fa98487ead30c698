"""A recorded episode holds what was observed, commanded and rewarded, and nothing else."""

from collections.abc import Iterator
from dataclasses import FrozenInstanceError
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.wrappers import RecordEpisodeStatistics, TimeLimit
from numpy.typing import NDArray

from prp_gym.baselines import make_baseline
from prp_gym.errors import InvalidValueError, PolicyOutputError
from prp_gym.evaluation import record_episode
from prp_gym.tasks.scenario import SCENARIOS
from tests.support.controller_episodes import ENVIRONMENTS, ONE_EACH

Env = gymnasium.Env[Any, Any]
FULL = np.array([1.0, -1.0, 1.0])
STEPS, FREQUENCY = 25, 500


class Scripted:
    """A policy that repeats given actions and records how it was called."""

    def __init__(self, actions: Any) -> None:
        self.actions = np.atleast_2d(np.asarray(actions, dtype=np.float32))
        self.calls: list[tuple[NDArray[Any], Any, Any, bool]] = []

    def predict(
        self,
        observation: NDArray[Any],
        state: Any = None,
        episode_start: NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[NDArray[Any], Any]:
        self.calls.append((observation, state, episode_start, deterministic))
        count = 0 if state is None else state[0]
        return self.actions[count % len(self.actions)], (count + 1,)


def scripted(env: Env, actions: Any) -> Scripted:
    """The same for a robot with fewer joints."""
    return Scripted(np.atleast_2d(actions)[:, : joints(env)])


def joints(env: Env) -> int:
    return int(np.prod(env.action_space.shape or ()))


def make(environment_id: str, **options: Any) -> Env:
    duration = options.pop("duration", STEPS / FREQUENCY)
    return gymnasium.make(environment_id, control_frequency=FREQUENCY, duration=duration, **options)


@pytest.fixture(params=ENVIRONMENTS)
def env(request: pytest.FixtureRequest) -> Iterator[Env]:
    made = make(request.param)
    yield made
    made.close()


def test_shapes_of_everything_recorded(env: Env) -> None:
    rollout = record_episode(scripted(env, [0.1, -0.1, 0.1]), env, seed=3)
    layout = env.get_wrapper_attr("task").ground_truth_layout
    assert set(layout.names) >= set(env.get_wrapper_attr("observation_layout").names)
    assert set(rollout.fields) == set(layout.names)
    for field in layout.fields:
        assert rollout.fields[field.name].shape == (STEPS + 1, *field.shape)
    assert rollout.torque.shape == rollout.applied_torque.shape == (STEPS, joints(env))
    assert rollout.reward.shape == rollout.compute_time.shape == (STEPS,)
    assert {name: values.shape for name, values in rollout.info.items()} == {
        field.name: (STEPS,) for field in env.get_wrapper_attr("info_fields")
    }


def test_facts_of_the_episode_are_those_of_the_environment(env: Env) -> None:
    rollout = record_episode(scripted(env, [0.0, 0.0, 0.0]), env, seed=7)
    assert env.spec is not None
    assert rollout.environment_id == env.spec.id
    assert (rollout.scenario, rollout.seed, rollout.diverged) == ("randomized", 7, False)
    assert (rollout.period, rollout.duration) == (1.0 / FREQUENCY, STEPS / FREQUENCY)
    np.testing.assert_allclose(rollout.time, np.arange(STEPS + 1) / FREQUENCY, rtol=1e-15)
    np.testing.assert_allclose(rollout.info["time"], rollout.time[1:], rtol=1e-15)
    assert (rollout.compute_time > 0.0).all()


def test_rows_are_those_of_a_loop_by_hand(env: Env) -> None:
    actions = np.random.default_rng(1).uniform(-1.0, 1.0, size=(STEPS, joints(env))).astype(np.float32)
    rollout = record_episode(Scripted(actions), env, seed=5)
    observation, _ = env.reset(seed=5)
    observations, rewards, saturated = [observation], [], []
    for action in actions:
        observation, reward, _, truncated, info = env.step(action)
        observations.append(observation)
        rewards.append(reward)
        saturated.append(info["cost_saturation"])
    assert truncated
    for name, values in env.get_wrapper_attr("observation_layout").split(np.array(observations)).items():
        np.testing.assert_array_equal(rollout.fields[name], values)
    np.testing.assert_array_equal(rollout.reward, rewards)
    np.testing.assert_array_equal(rollout.info["cost_saturation"], saturated)
    np.testing.assert_array_equal(
        rollout.torque, actions.astype(np.float64) * env.get_wrapper_attr("torque_limit")
    )


def test_torque_beyond_the_actuators_is_recorded_as_it_was_clipped(env: Env) -> None:
    rollout = record_episode(scripted(env, [3.0, -2.0, 0.5]), env, seed=5)
    one_joint = joints(env) == 1
    clipped = [30.0] if one_joint else [50.0, -100.0, 5.0]
    np.testing.assert_array_equal(rollout.torque, np.tile(clipped, (STEPS, 1)))
    np.testing.assert_array_equal(rollout.info["cost_saturation"], 1.0 if one_joint else 2.0)


def test_policy_is_told_where_the_episode_starts_and_gets_its_state_back(env: Env) -> None:
    policy = scripted(env, [0.0, 0.0, 0.0])
    record_episode(policy, env, seed=0)
    record_episode(policy, env, seed=1)
    states = [state for _, state, _, _ in policy.calls]
    assert states == 2 * [None, *((count,) for count in range(1, STEPS))]
    starts = [bool(start[0]) for _, _, start, _ in policy.calls]
    assert starts == 2 * [True, *[False] * (STEPS - 1)]
    assert all(deterministic for *_, deterministic in policy.calls)


def test_policy_sees_the_recorded_observations(env: Env) -> None:
    policy = scripted(env, [0.2, 0.0, 0.0])
    rollout = record_episode(policy, env, seed=2)
    seen = np.array([observation for observation, *_ in policy.calls])
    for name, values in env.get_wrapper_attr("observation_layout").split(seen).items():
        np.testing.assert_array_equal(rollout.fields[name][:-1], values)


def test_seed_decides_the_episode(env: Env) -> None:
    policy = scripted(env, [0.1, 0.1, 0.1])
    first, other, again = (record_episode(policy, env, seed=seed) for seed in (4, 5, 4))
    np.testing.assert_array_equal(first.fields["joint_position"], again.fields["joint_position"])
    assert (first.fields["joint_position"][0] != other.fields["joint_position"][0]).all()


def test_options_reach_the_reset(env: Env) -> None:
    start = [0.3, -0.12, -0.4][: joints(env)]
    rollout = record_episode(scripted(env, [0.0, 0.0, 0.0]), env, seed=0, options={"joint_position": start})
    np.testing.assert_allclose(rollout.fields["joint_position"][0], start, rtol=1e-15)


def test_wrappers_that_leave_observations_alone_change_nothing(env: Env) -> None:
    policy = scripted(env, [0.1, 0.1, 0.1])
    bare, wrapped = record_episode(policy, env, 6), record_episode(policy, RecordEpisodeStatistics(env), 6)
    np.testing.assert_array_equal(bare.reward, wrapped.reward)
    assert set(bare.info) == set(wrapped.info)


def test_episode_cut_short_by_a_wrapper_is_recorded_as_far_as_it_went(env: Env) -> None:
    rollout = record_episode(scripted(env, [0.0, 0.0, 0.0]), TimeLimit(env, max_episode_steps=10), seed=0)
    assert (len(rollout.reward), rollout.diverged) == (10, False)
    assert rollout.duration == STEPS / FREQUENCY


@pytest.mark.parametrize("environment_id", ENVIRONMENTS)
def test_divergence_ends_the_episode_and_is_recorded(environment_id: str) -> None:
    env = make(environment_id, scenario="report", torque_limit=None)
    rollout = record_episode(scripted(env, FULL), env, seed=0)
    env.close()
    assert rollout.diverged
    assert 1 <= len(rollout.reward) < STEPS
    assert rollout.reward[-1] == 0.0
    assert all(np.isfinite(values).all() for values in rollout.fields.values())


@pytest.mark.parametrize("scenario", SCENARIOS)
@pytest.mark.parametrize(("environment_id", "controller"), ONE_EACH, ids=map("-".join, ONE_EACH))
def test_every_controller_s_episode_runs_its_whole_length(
    environment_id: str, controller: str, scenario: str
) -> None:
    made = make(environment_id, scenario=scenario, duration=0.2)
    rollout = record_episode(make_baseline(controller, made), made, seed=0)
    assert (len(rollout.reward), rollout.scenario, rollout.diverged) == (100, scenario, False)
    made.close()


def test_environment_of_another_suite_is_refused() -> None:
    foreign = gymnasium.make("CartPole-v1")
    with pytest.raises(InvalidValueError, match="an environment of prp_gym"):
        record_episode(Scripted([0.0]), foreign, seed=0)
    foreign.close()


def test_action_of_another_shape_is_refused(env: Env) -> None:
    with pytest.raises(PolicyOutputError, match=rf"an action of shape \({joints(env) + 1},\)"):
        record_episode(Scripted(np.zeros(joints(env) + 1)), env, seed=0)


def test_rollout_cannot_be_reassigned(env: Env) -> None:
    rollout = record_episode(scripted(env, [0.0, 0.0, 0.0]), env, seed=0)
    with pytest.raises(FrozenInstanceError):
        rollout.seed = 1  # type: ignore[misc]
