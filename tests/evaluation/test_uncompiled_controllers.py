"""Controllers that compiled code cannot run: in the loop, with the results that they have there."""

import itertools
import math
import threading
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from prp_gym import make_baseline
from prp_gym.baselines.joint_pd import JointPDController
from prp_gym.evaluation import evaluate, record_episode
from prp_gym.evaluation.batch import record_episodes
from prp_gym.evaluation.compiled_batch import record_compiled
from tests.support.compiled_episodes import (
    SEEDS,
    TRACKING,
    altered,
    assert_same_episodes,
    assert_same_outcome,
    compiled,
    environment,
    made,
    own,
    plain,
)
from tests.support.compiler import needs_compiler

pytestmark = [needs_compiler, pytest.mark.usefixtures("timed_once")]


class Counter:
    """Something that a controller may hold, which counts."""

    def __init__(self) -> None:
        self.count = 0.0

    def next(self) -> float:
        self.count = self.count + 1.0
        return 1.0 + 0.01 * self.count


def in_attribute(self: Any, torque: Any, q: Any) -> Any:
    self.count = self.count + 1.0
    return torque * (1.0 + 0.01 * self.count)


def in_attribute_for_later(self: Any, torque: Any, q: Any) -> Any:
    self.count = self.count + 1
    return torque if self.count < 10 else 0.5 * torque


def in_list(self: Any, torque: Any, q: Any) -> Any:
    self.kept.append(q)
    return torque * (1.0 + 0.01 * len(self.kept))


def in_whole_numbers(self: Any, torque: Any, q: Any) -> Any:
    self.counts[0] += 1
    return torque * (1.0 + 0.01 * self.counts[0])


def last_position(self: Any, torque: Any, q: Any) -> Any:
    change = 0.0 if self.last is None else q - self.last
    self.last = q
    return torque - 5.0 * change


def with_state(kind: Any, *shape: int) -> type[JointPDController]:
    """A class of controllers that count the periods in a state of some kind, of N or of one."""

    class Counting(JointPDController):
        def initial_state(self, observed: Any) -> Any:
            lead = shape or observed["joint_position"].shape
            return (np.zeros(lead, dtype=kind),)

        def control(self, observed: Any, state: Any) -> Any:
            (count,) = state
            return self.torque(observed) * (1.0 + 0.01 * count), (count + 1,)

    return Counting


REFUSED: dict[str, Callable[[], Any]] = {
    "branch_on_data": altered(lambda self, torque, q: -q if (q > 0.3).any() else torque),
    "float_of_data": altered(lambda self, torque, q: torque * float(q[..., 0].max())),
    "function_of_math": altered(lambda self, torque, q: torque * math.cos(q.max())),
    "whole_number_of_data": altered(lambda self, torque, q: torque / (2 + int(q.max()))),
    "method_of_arrays": altered(lambda self, torque, q: torque * q.mean(axis=-1, keepdims=True)),
    "array_of_data": altered(lambda self, torque, q: 0.5 * np.array(torque)),
    "matrix_product": altered(lambda self, torque, q: torque @ np.diag([0.5, 1.0, 2.0])),
    "single_precision": altered(lambda self, torque, q: torque.astype(np.float32) * 1.1),
    "state_in_an_attribute": altered(in_attribute, count=lambda: 0.0),
    "state_that_matters_later": altered(in_attribute_for_later, count=lambda: 0),
    "state_in_a_list": altered(in_list, kept=list),
    "state_in_whole_numbers": altered(in_whole_numbers, counts=lambda: np.zeros(1, dtype=int)),
    "state_in_a_helper": altered(lambda self, torque, q: torque * self.counter.next(), counter=Counter),
    "last_position": altered(last_position, last=lambda: None),
    "random_numbers": altered(
        lambda self, torque, q: torque * self.rng.uniform(), rng=lambda: np.random.default_rng(1)
    ),
    "lock": altered(lambda self, torque, q: 0.5 * torque, lock=threading.Lock),
    "whole_numbers_as_state": lambda: own(with_state(np.int64)),
    "single_precision_as_state": lambda: own(with_state(np.float32)),
    "state_of_all_environments": lambda: own(with_state(np.float64, 1)),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_compiled_is_run_as_before(name: str) -> None:
    make, env = REFUSED[name], environment()
    assert record_compiled(make(), env, SEEDS) is None
    expected = assert_same_outcome(make)
    assert (expected[0].torque != compiled(plain(), env, SEEDS)[0].torque).any()


def test_numbers_from_outside_of_the_controller_are_no_constants() -> None:
    numbers = itertools.count(1)
    counting = altered(lambda self, torque, q: torque / next(numbers))
    assert record_compiled(counting(), environment(), SEEDS) is None


def test_one_episode_of_what_cannot_be_compiled_is_run_alone() -> None:
    env = made(TRACKING, "report", duration=0.06)
    make = REFUSED["state_in_an_attribute"]
    (found,) = evaluate(make(), env, episodes=5, seed=3).rollouts
    assert_same_episodes([found], [record_episode(make(), env, 3)])


def test_a_task_that_keeps_what_it_does_not_declare_is_run_as_before(monkeypatch: pytest.MonkeyPatch) -> None:
    env = made("PRP-Force-v0", duration=0.06)
    policy = make_baseline("parallel_force_position", env)
    expected = compiled(policy, env, SEEDS)
    monkeypatch.setattr(type(env.task.parts.errors), "state_arrays", {})
    assert record_compiled(policy, env, SEEDS) is None
    assert_same_episodes(record_episodes(policy, env, SEEDS), expected)


class Halving:
    """Halves the actions of the class after it."""

    def predict(self, *arguments: Any, **keywords: Any) -> Any:
        action, state = super().predict(*arguments, **keywords)  # type: ignore[misc]
        return 0.5 * action, state


class Half(Halving, JointPDController):
    """Takes its `predict` from a class that is no controller."""


class OwnPredict(JointPDController):
    def predict(self, *arguments: Any, **keywords: Any) -> Any:
        action, state = super().predict(*arguments, **keywords)
        return 0.5 * action, state


class Inherited(OwnPredict):
    """Has the `predict` of its base."""


class Wrapper:
    """Passes on what it does not have itself."""

    def __init__(self) -> None:
        self._policy = plain()

    def __getattr__(self, name: str) -> Any:
        return getattr(plain(), name)

    def predict(self, *arguments: Any, **keywords: Any) -> Any:
        action, state = self._policy.predict(*arguments, **keywords)
        return 0.5 * action, state


def with_attribute() -> Any:
    """A controller whose `predict` was replaced."""
    policy = own(JointPDController)
    policy.predict = Wrapper().predict
    return policy


OWN_PREDICT: dict[str, Callable[[], Any]] = {
    "subclass": lambda: own(OwnPredict),
    "subclass_of_a_subclass": lambda: own(Inherited),
    "further_base": lambda: own(Half),
    "attribute": with_attribute,
    "wrapper": Wrapper,
}


@pytest.mark.parametrize("name", OWN_PREDICT)
def test_a_predict_of_its_own_is_what_runs(name: str) -> None:
    expected = assert_same_outcome(OWN_PREDICT[name])
    whole = compiled(plain(), environment(), SEEDS)
    for half, one in zip(expected, whole, strict=True):
        moved = one.torque[0] != 0.0
        # actions are float32
        np.testing.assert_allclose(half.torque[0][moved] / one.torque[0][moved], 0.5, rtol=1e-6)
        assert moved.any()
