"""The step of a single environment in few calls: the results of the step of N environments, bit for bit."""

import copy
import pickle
from typing import Any

import gymnasium
import numpy as np
import pytest

import prp_gym
from prp_gym.envs import PRPEnv
from prp_gym.envs.core.compiled_run import CompiledPeriods
from prp_gym.errors import EpisodeError, NonFiniteError, ShapeError
from prp_gym.tasks.setup import COMPILED, MUJOCO
from tests.support.compiler import needs_compiler

pytestmark = needs_compiler

TASK = "PRP-Force-v0"  # where one task stands for all


def made(engine: str, environment_id: str = TASK, **keywords: Any) -> PRPEnv:
    given = {"scenario": "randomized", "duration": 0.1, **keywords}
    env = gymnasium.make(environment_id, engine=engine, **given).unwrapped
    assert isinstance(env, PRPEnv)
    return env


def with_listener(env: PRPEnv) -> PRPEnv:
    """The same environment, whose steps go through those of N environments."""
    env.loop.listen(lambda _: None)
    return env


def actions(count: int, size: int) -> Any:
    return np.random.default_rng(7).uniform(-1.3, 1.3, (count, size)).astype(np.float32)


def assert_same(found: Any, expected: Any) -> None:
    assert found[0].tobytes() == expected[0].tobytes()
    assert found[1:] == expected[1:]
    for first, second in zip(found[1:4], expected[1:4], strict=True):
        assert type(first) is type(second)


@pytest.fixture(params=[MUJOCO, COMPILED])
def engine(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.mark.parametrize("environment_id", prp_gym.list_envs())
def test_steps_have_the_results_of_those_of_many_environments(environment_id: str, engine: str) -> None:
    env, other = made(engine, environment_id), with_listener(made(engine, environment_id))
    for seed in range(3):
        assert env.reset(seed=seed)[0].tobytes() == other.reset(seed=seed)[0].tobytes()
        for action in actions(50, env.action_space.shape[0]):  # type: ignore[index]
            found = env.step(action)
            assert_same(found, other.step(action))
            assert env.ground_truth.tobytes() == other.ground_truth.tobytes()
            assert env.commanded_torque.tobytes() == other.commanded_torque.tobytes()
            assert env.applied_torque.tobytes() == other.applied_torque.tobytes()
            if found[2]:
                break
        else:
            assert found[3]


def test_such_a_step_takes_the_short_way(engine: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(*_: Any) -> None:
        raise AssertionError

    env = made(engine)
    env.reset(seed=0)
    monkeypatch.setattr(CompiledPeriods, "step", refused)
    env.step(np.zeros(3, dtype=np.float32))


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_action_that_is_not_finite_is_refused_and_changes_nothing(
    value: float, kind: Any, engine: str
) -> None:
    env, other = made(engine), made(engine)
    env.reset(seed=0)
    other.reset(seed=0)
    with pytest.raises(NonFiniteError, match="action"):
        env.step(np.array([0.1, value, 0.0], dtype=kind))
    for action in actions(3, 3):
        assert_same(env.step(action), other.step(action))


def test_actions_of_any_kind_are_the_same_numbers(engine: str) -> None:
    numbers = [0.5, -1.0, 0.25]
    given = (numbers, tuple(numbers), np.array(numbers), np.array(numbers, dtype=np.float32))
    results = []
    for action in given:
        env = made(engine)
        env.reset(seed=2)
        results.append(env.step(action))  # type: ignore[arg-type]
    for found in results[1:]:
        assert_same(found, results[0])


def test_action_of_another_shape_is_refused(engine: str) -> None:
    env = made(engine)
    env.reset(seed=0)
    for shape in ((2,), (1, 3), ()):
        with pytest.raises(ShapeError, match="action"):
            env.step(np.zeros(shape, dtype=np.float32))


def test_step_before_the_first_reset_is_refused(engine: str) -> None:
    with pytest.raises(EpisodeError, match="reset"):
        made(engine).step(np.zeros(3, dtype=np.float32))


def test_results_stay_as_they_are(engine: str) -> None:
    env = made(engine)
    env.reset(seed=0)
    observation, *_, info = env.step(np.full(3, 0.3))
    kept = observation.copy(), dict(info)
    observation_after, *_, info_after = env.step(np.full(3, -0.3))
    assert (observation == kept[0]).all()
    assert info == kept[1] != info_after
    observation_after[:] = np.nan  # a caller's change
    assert np.isfinite(env.step(np.zeros(3))[0]).all()


def test_divergence_ends_the_episode(engine: str) -> None:
    env, other = made(engine), with_listener(made(engine))
    results = []
    for each in (env, other):
        each.reset(seed=0)
        each.physics.watch(np.array([10.0, 10.0, 10.0, 10.0, 10.0, 1e-3]))  # of the speed of joint 3 [rad/s]
        ended = False
        while not ended:
            outcome = each.step(np.ones(3))
            ended = outcome[2]
        results.append(outcome)
        with pytest.raises(EpisodeError, match="diverged"):
            each.step(np.ones(3))
        each.reset(seed=1)
        results.append(each.step(np.zeros(3)))
    assert_same(results[0], results[2])
    assert results[0][1] == 0.0
    assert not results[0][3]
    assert_same(results[1], results[3])


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))])
def test_copies_and_restored_states_go_on_as_the_original(copied: Any, engine: str) -> None:
    env, restored = made(engine), made(engine)
    env.reset(seed=3)
    restored.reset(seed=4)
    env.step(np.full(3, 0.3))
    other = copied(env)
    restored.set_state(env.get_state())
    for action in actions(5, 3):
        found = env.step(action)
        assert_same(other.step(action), found)
        assert_same(restored.step(action), found)
