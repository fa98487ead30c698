"""Derivatives of scores by settings against central differences of the scores, and what is refused."""

from dataclasses import replace
from functools import cache
from typing import Any

import gymnasium
import numpy as np
import pytest

import prp_gym
from prp_gym.baselines.joint_pd import JointPDController
from prp_gym.errors import InvalidValueError, UntraceableError
from prp_gym.evaluation.compiled_controller import CONSTANTS
from prp_gym.gradients.score_gradient import ScoreGradient, score_gradient
from prp_gym.robot.arrays import Array
from prp_gym.symbolic.lifting import numbers_of
from tests.support.compiler import needs_compiler

pytestmark = needs_compiler

SEEDS = (5, 6)
STEPS = (1e-5, 1e-6, 1e-7)  # relative steps of central differences; short ones rarely cross a switch
TOLERANCE = (
    1e-7  # of score per relative change: rounding of scores, 1e-16, over the shortest step is 1e-9, ...
)
# ... and truncation at the longest 1e-10 times third derivatives up to 100


@cache
def made(environment_id: str, scenario: str, duration: float = 1.0, engine: str = "compiled") -> Any:
    return gymnasium.make(environment_id, scenario=scenario, duration=duration, engine=engine)


def moved(controller: Any, name: str, index: int, factor: float) -> Any:
    """The same controller with one component of a setting times a factor."""
    value = np.array(getattr(controller.settings, name), dtype=np.float64)
    value.flat[index] *= factor
    given = value if value.ndim else float(value)
    return type(controller)(controller.interface, replace(controller.settings, **{name: given}))


def slope(env: Any, controller: Any, name: str, index: int, exact: float) -> float:
    """The central difference of the score by the logarithm of one component of a setting.

    Where a step crosses a switch, such as the period of the first touch, the score jumps, and the difference
    grows without bound as the step shrinks: of several steps, that is taken which is nearest to `exact`.
    """
    found = []
    for step in STEPS:
        more, less = (
            score_gradient(env, moved(controller, name, index, factor), SEEDS).score
            for factor in (1.0 + step, 1.0 - step)
        )
        found.append((more - less) / (2.0 * step))
    return min(found, key=lambda value: abs(value - exact))


CASES = {
    "free": ("PRP-JointTracking-v0", "joint_inverse_dynamics", "randomized", 1.0),
    "delay_and_noise": ("PRP-PoseTracking-v0", "operational_pd", "realistic", 1.0),
    "estimates_in_the_state": ("PRP-JointTracking-v0", "adaptive", "realistic", 1.0),
    "link": ("PRP-Adaptive-v0", "adaptive", "randomized", 1.0),
    "saturated": ("PRP-JointRegulation-v0", "time_optimal", "randomized", 1.0),
    "contact": ("PRP-Compliance-v0", "compliance", "randomized", 1.0),
    "impedance_in_contact": ("PRP-Impedance-v0", "impedance", "realistic", 2.0),
    "blind_push": ("PRP-Force-v0", "force_feedforward", "randomized", 2.0),
}


@pytest.mark.parametrize("case", CASES)
def test_derivatives_by_settings_are_those_of_differences(case: str) -> None:
    environment_id, name, scenario, duration = CASES[case]
    env = made(environment_id, scenario, duration)
    controller: Any = prp_gym.make_baseline(name, env)
    found = score_gradient(env, controller, SEEDS)
    settings = controller.settings
    assert set(found.by_setting) <= set(settings.vectors) | set(settings.numbers)
    checked = 0
    for setting, derivative in found.by_setting.items():
        value = np.asarray(getattr(settings, setting), dtype=np.float64)
        assert derivative.shape == value.shape
        relative = np.atleast_1d(derivative * value)
        index = int(np.argmax(np.abs(relative)))
        difference = slope(env, controller, setting, index, float(relative[index]))
        assert relative[index] == pytest.approx(difference, rel=1e-6, abs=TOLERANCE)
        checked += abs(difference) > 10.0 * TOLERANCE
    assert checked >= 2  # differences that are much larger than the tolerance


def test_settings_of_a_force_controller_through_contact_and_friction() -> None:
    env = made("PRP-ForcePosition-v0", "realistic", 2.0)
    controller: Any = prp_gym.make_baseline("force_inner_position", env)
    found = score_gradient(env, controller, SEEDS)
    for name in ("bandwidth", "approach_factor", "approach_deceleration"):  # away from switches
        exact = float(found.by_setting[name]) * getattr(controller.settings, name)
        difference = slope(env, controller, name, 0, exact)
        assert exact == pytest.approx(difference, rel=1e-6, abs=TOLERANCE)
        assert abs(difference) > 1e-5


def test_scores_are_those_of_an_evaluation() -> None:
    env = made("PRP-Force-v0", "realistic")
    controller = prp_gym.make_baseline("force_inner_position", env)
    found = score_gradient(env, controller, range(4))
    evaluation: Any = prp_gym.evaluate(controller, env, episodes=4, seed=0)
    expected = evaluation.metrics["score"][:, 0]
    # actions rounded to 6e-8 move a score by about as much
    np.testing.assert_allclose(found.scores, expected, atol=1e-6)
    assert not found.diverged.any()


@pytest.mark.parametrize("engine", ["mujoco", "compiled"])
def test_the_engine_of_the_environment_does_not_matter(engine: str) -> None:
    env = made("PRP-JointTracking-v0", "realistic", 0.5, engine)
    controller = prp_gym.make_baseline("joint_pd", env)
    found = score_gradient(env, controller, SEEDS)
    other = score_gradient(made("PRP-JointTracking-v0", "realistic", 0.5), controller, SEEDS)
    assert_same(found, other)


def assert_same(found: ScoreGradient, other: ScoreGradient) -> None:
    np.testing.assert_array_equal(found.scores, other.scores)
    np.testing.assert_array_equal(found.by_number, other.by_number)


def test_an_episode_does_not_depend_on_the_others() -> None:
    env = made("PRP-Impedance-v0", "realistic", 0.2)
    controller = prp_gym.make_baseline("impedance", env)
    seeds = range(130)  # which two threads share
    together = score_gradient(env, controller, seeds)
    alone = [score_gradient(env, controller, [seed]) for seed in (0, 64, 129)]
    np.testing.assert_array_equal(together.scores[[0, 64, 129]], [one.score for one in alone])
    some = score_gradient(env, controller, seeds)
    assert_same(together, some)


class Linear(JointPDController):
    """A controller of no declared settings: a matrix of numbers times the observation."""

    def __init__(self, interface: Any, settings: Any, weights: Array) -> None:
        super().__init__(interface, settings)
        self.settings = None  # type: ignore[assignment]
        self.weights = weights

    def torque(self, observed: Any) -> Any:
        fields = np.concatenate([observed[name] for name in sorted(observed)], axis=-1)
        drive = (fields[..., None] * self.weights).sum(axis=-2)
        return drive / np.sqrt(1.0 + drive * drive) * self.interface.torque_limit


def test_the_weights_of_a_policy_of_ones_own() -> None:
    env = made("PRP-JointTracking-v0", "randomized", 0.1)  # short, before motions without feedback hit stops
    packaged: Any = prp_gym.make_baseline("joint_pd", env)
    size = packaged.interface.layout.size
    weights = 1e-3 * np.random.default_rng(0).standard_normal((size, 3))

    def policy(values: Array) -> Linear:
        return Linear(packaged.interface, packaged.settings, values)

    found = score_gradient(env, policy(weights), SEEDS)
    assert found.by_setting == {}
    direction = np.random.default_rng(1).standard_normal(weights.shape)
    more, less = (
        score_gradient(env, policy(weights + sign * STEPS[0] * direction), SEEDS).score
        for sign in (1.0, -1.0)
    )
    numbers = numbers_in_order(policy(weights), policy(weights + direction))
    assert found.by_number @ numbers == pytest.approx((more - less) / (2.0 * STEPS[0]), rel=1e-5)


def numbers_in_order(first: Any, second: Any) -> Array:
    """How far the numbers of one controller are from those of another."""
    one, other = (numbers_of(each, CONSTANTS) for each in (first, second))
    return np.where(one == other, 0.0, other - np.where(np.isfinite(one), one, 0.0))


def test_a_divergence_ends_the_score() -> None:
    env = made("PRP-JointTracking-v0", "randomized", 0.5)
    controller: Any = prp_gym.make_baseline("joint_pd", env)
    stiff = replace(controller.settings, derivative_gain=np.full(3, 1e8))
    found = score_gradient(env, type(controller)(controller.interface, stiff), SEEDS)
    if found.diverged.any():
        assert (found.scores[found.diverged] < 1.0).all()
    assert np.isfinite(found.scores).all()


class Predicts(JointPDController):
    def predict(self, *arguments: Any, **options: Any) -> Any:
        return super().predict(*arguments, **options)


class Converts(JointPDController):
    def torque(self, observed: Any) -> Any:
        return float(self.settings.proportional_gain[0]) * super().torque(observed)


def test_what_has_no_derivatives_is_refused() -> None:
    env = made("PRP-JointTracking-v0", "randomized", 0.5)
    controller: Any = prp_gym.make_baseline("joint_pd", env)
    with pytest.raises(InvalidValueError, match="seeds"):
        score_gradient(env, controller, [])
    with pytest.raises(UntraceableError, match="predict"):
        score_gradient(env, Predicts(controller.interface, controller.settings), SEEDS)
    with pytest.raises(UntraceableError, match="no derivative"):
        score_gradient(env, Converts(controller.interface, controller.settings), SEEDS)
    with_mode = gymnasium.make("PRP-Impedance-v0", action_mode="variable_impedance", control_frequency=50)
    with pytest.raises(InvalidValueError, match="action_mode"):
        score_gradient(with_mode, controller, SEEDS)
