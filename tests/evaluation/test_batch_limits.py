"""Episodes side by side: for which environments, how many at a time, and how policies are timed."""

import time
from typing import Any

import gymnasium
import numpy as np
import pytest

import prp_gym
from prp_gym.baselines import make_baseline
from prp_gym.envs import PRPEnv
from prp_gym.evaluation import batch, evaluate, record_episode
from prp_gym.evaluation.batch import can_batch, record_episodes
from tests.evaluation.test_batch import assert_same
from tests.support.controller_episodes import make

TRACKING = "PRP-JointTracking-v0"
JOINTS, LAYERS, HIDDEN = 3, 2, 4


class Slower(PRPEnv):
    """Steps in its own way."""

    def step(self, action: Any) -> Any:
        return super().step(0.5 * np.asarray(action))


class Elsewhere(PRPEnv):
    """Resets in its own way."""

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> Any:
        return super().reset(seed=seed, options={"joint_position": (0.3, -0.1, 0.2)})


class Renamed(PRPEnv):
    """Changes nothing."""


class Recurrent:
    """A policy with the state (layers, environments, hidden) of Stable-Baselines3's recurrent ones.

    It counts the observations of every episode, each environment apart.
    """

    batched = True

    def __init__(self) -> None:
        self.first: list[int] = []
        self.seen: list[tuple[int, ...]] = []

    def predict(
        self, observation: Any, state: Any = None, episode_start: Any = None, deterministic: bool = True
    ) -> tuple[Any, Any]:
        rows = 1 if np.ndim(observation) == 1 else len(observation)
        if state is None:
            self.first.append(rows)
            state = np.zeros((LAYERS, rows, HIDDEN))
        assert state.shape == (LAYERS, rows, HIDDEN)
        assert np.shape(episode_start) == (rows,)
        fresh = np.asarray(episode_start)[None, :, None]
        state = np.where(fresh, 0.0, state) + 1.0
        self.seen.append(np.shape(observation))
        action = 1e-3 * state[0, :, :JOINTS]
        return (action[0] if np.ndim(observation) == 1 else action).astype(np.float32), state


class DictionaryRecurrent(Recurrent):
    """The recurrent policy with its state in a dictionary."""

    def predict(
        self, observation: Any, state: Any = None, episode_start: Any = None, deterministic: bool = True
    ) -> tuple[Any, Any]:
        inner = None if state is None else state["hidden"]
        action, after = super().predict(observation, inner, episode_start, deterministic)
        return action, {"hidden": after}


def own(kind: type[PRPEnv], **keywords: Any) -> PRPEnv:
    return kind(TRACKING, scenario="randomized", duration=0.1, **keywords)


@pytest.mark.parametrize("kind", [Slower, Elsewhere])
def test_environment_that_steps_or_resets_in_its_own_way_is_run_one_by_one(kind: type[PRPEnv]) -> None:
    assert not can_batch(own(kind))


def test_own_step_and_reset_take_effect_in_an_evaluation() -> None:
    policy = make_baseline("joint_pd", own(PRPEnv))
    plain = evaluate(policy, own(PRPEnv), episodes=3).rollouts
    for rollout, other in zip(evaluate(policy, own(Slower), episodes=3).rollouts, plain, strict=True):
        # float32
        np.testing.assert_allclose(rollout.applied_torque[0], 0.5 * other.applied_torque[0], rtol=1e-6)
    for rollout in evaluate(policy, own(Elsewhere), episodes=3).rollouts:
        np.testing.assert_array_equal(rollout.fields["joint_position"][0], (0.3, -0.1, 0.2))


def test_subclass_that_changes_nothing_is_run_side_by_side() -> None:
    assert can_batch(own(Renamed))
    for environment_id in prp_gym.list_envs():
        env = make(environment_id)
        assert can_batch(env)
        env.close()


@pytest.mark.parametrize("mode", ["rgb_array", "depth_array"])
def test_environment_that_renders_is_run_one_by_one(mode: str) -> None:
    env = gymnasium.make(TRACKING, render_mode=mode)
    assert not can_batch(env)
    assert not can_batch(env.unwrapped)
    env.close()


def test_many_episodes_are_run_in_parts_and_are_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    assert batch._SIDE_BY_SIDE == 64
    env = own(PRPEnv)
    policy = make_baseline("adaptive", env)
    whole = record_episodes(policy, env, range(3, 10))
    monkeypatch.setattr(batch, "_SIDE_BY_SIDE", 3)
    spied = Recurrent()
    record_episodes(spied, env, range(3, 10))
    assert {shape[0] for shape in spied.seen if len(shape) == 2} == {3, 1}
    parts = record_episodes(policy, env, range(3, 10))
    assert [rollout.seed for rollout in parts] == list(range(3, 10))
    for one, other in zip(whole, parts, strict=True):
        assert_same(one, other)


def test_at_most_sixty_four_episodes_are_run_side_by_side() -> None:
    env = PRPEnv(TRACKING, scenario="randomized", duration=0.004)
    spied = Recurrent()
    rollouts = record_episodes(spied, env, range(130))
    assert [rollout.seed for rollout in rollouts] == list(range(130))
    sizes = [shape[0] for shape in spied.seen if len(shape) == 2]
    assert sizes == [64, 64, 64, 64, 2, 2]


@pytest.mark.parametrize("kind", [Recurrent, DictionaryRecurrent])
def test_recurrent_policy_keeps_its_state_and_is_timed_on_first_actions(kind: type[Recurrent]) -> None:
    env, policy = own(PRPEnv), kind()
    rollouts = record_episodes(policy, env, range(5))
    # it computes a first action once for all episodes, and again at each of the 50 timed steps
    assert sorted(policy.first) == [1] * 50 + [5]
    count = np.arange(1, 51)[:, None] * np.ones(JOINTS)
    limit = env.torque_limit
    for rollout in rollouts:
        # the count of the episode, not of the timing: float32 of thousandths
        np.testing.assert_allclose(rollout.torque, 1e-3 * count * limit, rtol=1e-6)
        assert rollout.compute_time.shape == (50,)
        assert (rollout.compute_time > 0.0).all()
    assert evaluate(policy, env, episodes=4).compute_time > 0.0


@pytest.mark.parametrize("batched", [True, False])
def test_compute_time_of_an_action_includes_the_inner_controller_at_all_its_periods(
    batched: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    env = make(TRACKING, duration=0.1, action_mode="joint_position", control_frequency=100)
    inner: Any = env.unwrapped
    kind = type(inner.loop._mode)
    plain = kind.torque

    def slow(*args: Any) -> Any:
        time.sleep(0.001)
        return plain(*args)

    monkeypatch.setattr(kind, "torque", slow)
    policy = Recurrent()
    policy.batched = batched
    record = record_episodes(policy, env, [0])[0] if batched else record_episode(policy, env, 0)
    # five periods at 500 Hz for an action at 100 Hz; a sleep is never shorter than asked for
    assert record.compute_time.min() >= 0.005
    env.close()
