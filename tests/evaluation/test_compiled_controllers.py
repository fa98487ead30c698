"""Controllers of users' own in compiled code: functions and subclasses, and the errors that they make."""

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest

from prp_gym import controller, make_baseline
from prp_gym.baselines.joint_pd import JointPDController
from prp_gym.errors import InvalidValueError, NonFiniteError, PolicyOutputError, ShapeError
from tests.support.compiled_episodes import (
    SEEDS,
    altered,
    assert_same_episodes,
    assert_same_outcome,
    compiled,
    environment,
    looped,
    made,
    own,
    plain,
)
from tests.support.compiler import needs_compiler

pytestmark = [needs_compiler, pytest.mark.usefixtures("timed_once")]


@controller
def proportional(joint_position: Any, desired_joint_position: Any, *, gain: float = 60.0) -> Any:
    """A function with a setting."""
    return gain * (desired_joint_position - joint_position)


@controller
def of_the_model(
    model: Any, joint_velocity: Any, joint_position: Any, *, damping: Any = (2.0, 5.0, 0.1)
) -> Any:
    """A function of the nominal robot, with a vector as its setting."""
    return model.gravity_vector(joint_position) - damping * joint_velocity


@controller
def constant(joint_position: Any) -> Any:
    """The same torques whatever happens."""
    return np.ones(joint_position.shape)


FUNCTIONS = {"setting": proportional, "model": of_the_model, "constant": constant}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_functions_run_in_compiled_code(name: str) -> None:
    env, policy = environment(), FUNCTIONS[name].make(environment())
    assert_same_episodes(compiled(policy, env, SEEDS), looped(policy, env, SEEDS))


def test_settings_of_functions_are_inputs_of_one_compiled_function() -> None:
    env = environment()
    soft, stiff = (make_baseline(proportional, env, gain=gain) for gain in (10.0, 80.0))
    torques = [compiled(policy, env, SEEDS)[0].torque for policy in (soft, stiff)]
    np.testing.assert_allclose(torques[1][0], 8.0 * torques[0][0], rtol=1e-6)  # actions are float32
    for policy in (soft, stiff):
        assert_same_episodes(compiled(policy, env, SEEDS), looped(policy, env, SEEDS))


class Parity(JointPDController):
    """Has truth values as its state: whether the number of periods was odd."""

    def initial_state(self, observed: Any) -> Any:
        return (np.zeros(observed["joint_position"].shape, dtype=np.bool_),)

    def control(self, observed: Any, state: Any) -> Any:
        (odd,) = state
        return self.torque(observed) * np.where(odd, 0.5, 1.0), (~odd,)


class Mean(JointPDController):
    """Has the mean of all positions as its state, and acts in a way of its own."""

    def initial_state(self, observed: Any) -> Any:
        return observed["joint_position"] * 1.0, np.zeros(observed["joint_position"].shape[:-1])

    def act(self, observed: Any, state: Any) -> Any:
        action, _ = super().act(observed, ())
        mean, count = state
        mean = mean + (observed["joint_position"] - mean) / (count[..., None] + 2.0)
        return action.astype(np.float64) * np.cos(mean), (mean, count + 1.0)


COMPILED: dict[str, Callable[[], Any]] = {
    "function_of_data": altered(lambda self, torque, q: torque * np.exp(-np.abs(q))),
    "attribute": altered(lambda self, torque, q: torque * self.gain, gain=lambda: 0.7),
    "branch_on_a_number": altered(lambda self, torque, q: -q if self.gain > 0.5 else q, gain=lambda: 0.7),
    "module": altered(lambda self, torque, q: torque * self.library.cos(q), library=lambda: np),
    "infinite_torque": altered(lambda self, torque, q: np.copysign(np.inf, torque)),
    "truth_values_as_state": lambda: own(Parity),
    "own_act": lambda: own(Mean),
}


@pytest.mark.parametrize("name", COMPILED)
def test_subclasses_run_in_compiled_code(name: str) -> None:
    make, env = COMPILED[name], environment()
    with np.errstate(all="ignore"):
        expected = looped(make(), env, SEEDS)
    assert_same_episodes(compiled(make(), env, SEEDS), expected)
    assert (expected[0].torque != compiled(plain(), env, SEEDS)[0].torque).any()


def with_after(after: Callable[[Any], Any]) -> Callable[[], Any]:
    """Makes controllers whose state, ones at first, goes on by a function."""
    control = {"control": lambda self, observed, state: (self.torque(observed), (after(state[0]),))}
    start = {"initial_state": lambda self, observed: (np.ones(observed["joint_position"].shape),)}
    return lambda: own(type("StatefulByTest", (JointPDController,), {**start, **control}))


def with_action(change: Callable[[Any], Any]) -> Callable[[], Any]:
    """Makes controllers with another action."""

    class Changed(JointPDController):
        def act(self, observed: Any, state: Any) -> Any:
            action, after = super().act(observed, state)
            return change(action), after

    return lambda: own(Changed)


def returning(torque: Callable[[Any], Any]) -> Callable[[], Any]:
    """Makes controllers that are a function of the joint position."""

    @controller
    def returned(joint_position: Any) -> Any:
        return torque(joint_position)

    return lambda: returned.make(environment())


@cache
def in_the_second_episode(torque: float) -> Callable[[Any], Any]:
    """A function of the joint position that returns a torque in one of two episodes, and 1 in the other."""
    first, second = (
        rollout.fields["joint_position"][0, 0] for rollout in looped(plain(), environment(), SEEDS)
    )
    middle, side = (first + second) / 2.0, np.sign(second - first)
    return lambda q: np.where(side * (q[..., :1] - middle) > 0.0, torque, np.ones(3))


WRONG: dict[str, tuple[type[Exception], Callable[[], Any]]] = {
    "no_number": (PolicyOutputError, altered(lambda self, torque, q: np.sqrt(-1.0 - q * q))),
    "no_number_later": (
        PolicyOutputError,
        altered(lambda self, torque, q: torque * np.sqrt(0.04 - np.abs(q))),
    ),
    "state_without_number": (NonFiniteError, with_after(lambda ones: np.sqrt(ones - 1.5))),
    "huge_state": (InvalidValueError, with_after(lambda ones: ones * np.array([1.0, 10.0, 1.0]))),
    "longer_state": (ShapeError, with_after(lambda ones: np.concatenate([ones, ones], axis=-1))),
    "short_action": (PolicyOutputError, with_action(lambda action: action[..., :2])),
    "long_action": (PolicyOutputError, with_action(lambda action: action[..., [0, 1, 2, 0]])),
    "function_without_number": (NonFiniteError, returning(lambda q: np.log(q - q - 1.0))),
    "function_to_infinity": (NonFiniteError, returning(lambda q: 1.0 / (q - q))),
    "function_of_huge_torques": (InvalidValueError, returning(lambda q: 1e200 * np.copysign(1.0, q))),
    "huge_torques_in_one_episode": (InvalidValueError, returning(lambda q: in_the_second_episode(1e200)(q))),
    "infinity_in_one_episode": (NonFiniteError, returning(lambda q: in_the_second_episode(np.inf)(q))),
    "function_of_two_torques": (ShapeError, returning(lambda q: q[..., :2])),
}


@pytest.mark.parametrize("name", WRONG)
def test_errors_of_controllers_are_those_of_the_loop(name: str) -> None:
    error, make = WRONG[name]
    assert assert_same_outcome(make)[0] is error


def test_observations_of_another_size_are_refused_as_by_the_loop() -> None:
    other = made("PRP-ForcePosition-v0", duration=0.06)
    expected = assert_same_outcome(lambda: make_baseline("joint_pd", other))
    assert expected[0] is ShapeError
