"""Metrics on made-up motions whose values are known beforehand."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from prp_gym.evaluation import METRICS, Metric, Rollout, episode_metrics
from prp_gym.evaluation import metrics as m

Array = NDArray[np.float64]

PERIOD = 0.01
SAMPLES = 101
TIME: Array = np.arange(SAMPLES, dtype=np.float64) * PERIOD
GOAL = np.array([1.0, -0.2, 2.0])
ROUNDING = 1e-12  # sums of a few hundred numbers up to 100


def reference(goal: Array = GOAL) -> Array:
    return np.tile(goal, (SAMPLES, 1))


def jump(sample: int, goal: Array = GOAL, residue: float = 0.0) -> Array:
    """At home before a sample; from it on at the goal but for a share of the step."""
    actual = np.zeros((SAMPLES, 3))
    actual[sample:] = goal * (1.0 - residue)
    return actual


def random_motions(seed: int, *leading: int) -> tuple[Array, Array]:
    """Motions that approach constant goals, (..., SAMPLES, 3)."""
    rng = np.random.default_rng(seed)
    goal = rng.uniform(-2.0, 2.0, size=(*leading, 1, 3))
    rate = rng.uniform(2.0, 20.0, size=(*leading, 1, 3))
    wiggle = rng.uniform(-0.1, 0.1, size=(*leading, 1, 3)) * np.sin(9.0 * TIME)[:, None]
    decay = np.exp(-rate * TIME[:, None])
    return goal * (1.0 - decay) + wiggle * decay, np.broadcast_to(goal, (*leading, SAMPLES, 3)).copy()


def rollout(actual: Array, desired: Array, **changes: Any) -> Rollout:
    steps = len(actual) - 1
    content: dict[str, Any] = {
        "environment_id": "PRP-JointTracking-v0",
        "scenario": "randomized",
        "seed": 0,
        "period": PERIOD,
        "duration": 1.0,
        "fields": {
            "joint_position": actual,
            "joint_velocity": np.tile([1.0, -0.5, 2.0], (steps + 1, 1)),
            "desired_joint_position": desired,
        },
        "torque": np.tile([10.0, -20.0, 3.0], (steps, 1)),
        "applied_torque": np.tile([10.0, -20.0, 3.0], (steps, 1)),
        "reward": np.full(steps, 0.006),
        "info": {
            "cost_saturation": np.arange(steps) % 4,
            "cost_joint_stop": (np.arange(steps) < 25).astype(float),
        },
        "diverged": False,
        "compute_time": np.full(steps, 1e-5),
    }
    return Rollout(**{**content, **changes})


def test_root_mean_square_and_maximum_error_of_known_errors() -> None:
    error = np.zeros((SAMPLES, 3))
    error[:, 0] = 0.3
    error[:, 1] = 0.2 * (-1.0) ** np.arange(SAMPLES)
    error[7, 2] = -5.05
    actual = reference() - error
    expected = [0.3, 0.2, 5.05 / np.sqrt(SAMPLES)]
    np.testing.assert_allclose(m.root_mean_square_error(actual, reference()), expected, rtol=ROUNDING)
    np.testing.assert_allclose(m.maximum_error(actual, reference()), [0.3, 0.2, 5.05], rtol=ROUNDING)


@pytest.mark.parametrize("sample", [1, 40, SAMPLES - 1])
def test_settling_time_is_the_first_sample_inside_for_good(sample: int) -> None:
    assert m.settling_time(TIME, jump(sample), reference()) == pytest.approx(TIME[sample], abs=ROUNDING)


def test_settling_time_is_that_of_the_last_joint_to_leave_its_band() -> None:
    actual = jump(10)
    actual[60, 1] = GOAL[1] * 0.97
    assert m.settling_time(TIME, actual, reference()) == pytest.approx(TIME[61], abs=ROUNDING)


@pytest.mark.parametrize(("residue", "settles"), [(0.019, True), (-0.019, True), (0.021, False)])
def test_settling_band_is_two_percent_of_the_step_on_both_sides(residue: float, settles: bool) -> None:
    time = m.settling_time(TIME, jump(30, residue=residue), reference())
    assert time == pytest.approx(TIME[30] if settles else np.inf, abs=ROUNDING)


@pytest.mark.parametrize(("residue", "settles"), [(0.009, True), (0.011, False)])
def test_settling_band_is_relative_to_the_step_and_not_to_the_goal(residue: float, settles: bool) -> None:
    actual = jump(30, residue=residue)
    actual[:30] = GOAL / 2
    time = m.settling_time(TIME, actual, reference())
    assert time == pytest.approx(TIME[30] if settles else np.inf, abs=ROUNDING)


def test_settling_time_is_infinite_if_a_joint_is_outside_at_the_end() -> None:
    actual = jump(30)
    actual[-1, 2] = 0.0
    assert m.settling_time(TIME, actual, reference()) == np.inf


def test_settling_band_is_never_below_the_resolution() -> None:
    goal = np.array([1.0, 1e-3, 1.0])  # 2 % of joint 2's step would be 2e-5 m; the resolution is 2e-4 m
    near, far = jump(30, goal), jump(30, goal)
    near[30:, 1] = 1e-3 - 1.9e-4
    far[30:, 1] = 1e-3 - 2.1e-4
    assert m.settling_time(TIME, near, reference(goal)) == pytest.approx(TIME[30], abs=ROUNDING)
    assert m.settling_time(TIME, far, reference(goal)) == np.inf


def test_arm_that_starts_and_stays_at_its_goal_has_settled_at_once() -> None:
    assert m.settling_time(TIME, reference(), reference()) == 0.0


@pytest.mark.parametrize("goal", [GOAL, -GOAL])
def test_overshoot_is_counted_beyond_the_goal_whatever_the_direction(goal: Array) -> None:
    actual = jump(10, goal)
    actual[20, 2] = goal[2] * 1.25
    actual[30, 0] = goal[0] * 1.1
    assert m.overshoot(actual, reference(goal)) == pytest.approx(25.0, abs=1e2 * ROUNDING)


@pytest.mark.parametrize("goal", [GOAL, -GOAL])
def test_what_falls_short_or_leaves_backwards_is_no_overshoot(goal: Array) -> None:
    actual = jump(10, goal, residue=0.3)
    actual[5] = -0.5 * goal
    assert m.overshoot(actual, reference(goal)) == 0.0


def test_overshoot_is_relative_to_the_step_and_not_to_the_goal() -> None:
    start = np.array([0.5, -0.1, 1.0])
    actual = reference()
    actual[0] = start
    actual[50, 0] = 1.1
    assert m.overshoot(actual, reference()) == pytest.approx(100.0 * 0.1 / 0.5, abs=1e2 * ROUNDING)


def test_joint_without_a_step_has_no_overshoot() -> None:
    goal = np.array([1.0, 1e-4, 0.0])  # joint 2 moves less than the resolution, joint 3 not at all
    actual = jump(10, goal)
    actual[20, 1:] = 0.5
    actual[30, 0] = 1.02
    assert m.overshoot(actual, reference(goal)) == pytest.approx(2.0, abs=1e2 * ROUNDING)
    assert np.isnan(m.overshoot(actual, reference(np.array([0.0, 1e-4, -1e-3]))))


def test_steady_state_error_is_the_signed_mean_over_the_last_tenth() -> None:
    actual = jump(50)
    actual[-10:] = GOAL - np.array([0.01, -0.002, 0.03])
    actual[-10::2, 0] += 0.005
    actual[-11] = 7.0  # before the last tenth of 101 samples
    expected = [0.0075, -0.002, 0.03]
    np.testing.assert_allclose(m.steady_state_error(actual, reference()), expected, atol=ROUNDING)


def test_steady_state_error_of_a_short_episode_is_that_of_its_last_sample() -> None:
    actual = np.array([[0.0, 0.0, 0.0], [0.9, -0.1, 1.5]])
    expected = GOAL - actual[-1]
    np.testing.assert_allclose(m.steady_state_error(actual, reference()[:2]), expected, rtol=ROUNDING)


def test_moving_reference_has_no_settling_time_nor_overshoot() -> None:
    desired = reference()
    desired[30, 1] += 1e-9
    assert not m.is_constant(desired)
    assert np.isnan(m.settling_time(TIME, jump(10), desired))
    assert np.isnan(m.overshoot(jump(10), desired))


def test_steady_state_error_needs_a_reference_that_rests_at_the_end_only() -> None:
    early, late = reference(), reference()
    early[30, 1] += 0.1
    late[-3, 1] += 0.1
    np.testing.assert_array_equal(m.steady_state_error(jump(50), early), 0.0)
    assert np.isnan(m.steady_state_error(jump(50), late)).all()


def test_energy_of_constant_torque_and_speed_is_power_times_time() -> None:
    torque, velocity = np.tile([10.0, -20.0, 3.0], (100, 1)), np.tile([1.0, 0.5, -2.0], (101, 1))
    # |10·1| + |20·0.5| + |3·2| W for one second, or for two, whatever the signs
    assert m.mechanical_energy(torque, velocity, 0.01) == pytest.approx(26.0, rel=ROUNDING)
    assert m.mechanical_energy(torque, velocity, 0.02) == pytest.approx(52.0, rel=ROUNDING)


def test_energy_of_a_uniform_acceleration_is_force_times_way() -> None:
    velocity = np.zeros((101, 3))
    velocity[:, 1] = 4.0 * TIME  # the trapezoidal rule is exact: 2 m in a second
    torque = np.tile([5.0, -20.0, 5.0], (100, 1))
    assert m.mechanical_energy(torque, velocity, PERIOD) == pytest.approx(40.0, rel=ROUNDING)


def test_root_mean_square_and_rate_of_known_torques() -> None:
    ramp = np.arange(100.0)[:, None] * PERIOD * np.array([3.0, -50.0, 0.0])
    np.testing.assert_allclose(m.torque_rate(ramp, PERIOD), [3.0, 50.0, 0.0], rtol=1e-9)
    square = np.tile([2.0, 3.0, 0.0], (100, 1)) * (-1.0) ** np.arange(100)[:, None]
    np.testing.assert_allclose(m.root_mean_square(square), [2.0, 3.0, 0.0], rtol=ROUNDING)
    np.testing.assert_allclose(m.torque_rate(square, PERIOD), [400.0, 600.0, 0.0], rtol=ROUNDING)


BATCHED: dict[str, Callable[[Array, Array], NDArray[Any]]] = {
    "root_mean_square_error": m.root_mean_square_error,
    "maximum_error": m.maximum_error,
    "is_constant": lambda actual, desired: m.is_constant(desired),
    "settling_time": lambda actual, desired: m.settling_time(TIME, actual, desired),
    "overshoot": m.overshoot,
    "steady_state_error": m.steady_state_error,
    "mechanical_energy": lambda actual, desired: m.mechanical_energy(desired[..., 1:, :], actual, PERIOD),
    "root_mean_square": lambda actual, desired: m.root_mean_square(actual),
    "torque_rate": lambda actual, desired: m.torque_rate(actual, PERIOD),
}


@pytest.mark.parametrize("name", BATCHED)
def test_batch_equals_a_loop_over_single_episodes(name: str) -> None:
    actual, desired = random_motions(1, 2, 4)
    desired[0, 1, 50:] += 0.1  # a moving reference among constant ones
    actual[1, 2, -1] += 1.0  # and one that does not settle
    together = BATCHED[name](actual, desired)
    assert together.shape[:2] == (2, 4)
    for index in np.ndindex(2, 4):
        # sums over other strides may round differently
        np.testing.assert_allclose(
            together[index], BATCHED[name](actual[index], desired[index]), rtol=ROUNDING, atol=ROUNDING
        )


EXPECTED = {
    "score": [0.6],
    "joint_rmse": [0.1, 0.02, 0.2],
    "joint_maximum_error": [1.0, 0.2, 2.0],
    "settling_time": [0.01],
    "overshoot": [0.0],
    "steady_state_error": [0.0, 0.0, 0.0],
    "energy": [26.0],
    "torque_rms": [10.0, 20.0, 3.0],
    "torque_rate": [0.0, 0.0, 0.0],
    "saturation": [50.0],
    "joint_stop": [25.0 / 3.0],
    "divergence": [0.0],
}


def test_every_declared_metric_is_expected() -> None:
    assert set(EXPECTED) == {metric.name for metric in METRICS}
    assert len(EXPECTED) == len(METRICS)


@pytest.mark.parametrize("metric", METRICS, ids=lambda metric: metric.name)
def test_declared_metric_of_a_known_episode(metric: Metric) -> None:
    episode = rollout(jump(1), reference())
    values = metric.compute(episode)
    assert values.shape == (len(metric.units),)
    scale = 1.0 / np.sqrt(1.01) if metric.name == "joint_rmse" else 1.0  # 101 samples, not 100
    np.testing.assert_allclose(values, scale * np.array(EXPECTED[metric.name]), rtol=1e-10, atol=1e-10)
    np.testing.assert_array_equal(episode_metrics(episode)[metric.name], values)
    assert metric.definition
    assert metric.higher_is_better == (metric.name == "score")


def test_divergence_is_counted() -> None:
    np.testing.assert_array_equal(
        episode_metrics(rollout(jump(1), reference(), diverged=True))["divergence"], [100.0]
    )


def test_metrics_without_their_fields_are_left_out() -> None:
    bare = rollout(jump(1), reference(), fields={"joint_velocity": np.zeros((SAMPLES, 3))})
    missing = {metric.name for metric in METRICS if "joint_position" in metric.requires}
    assert missing
    assert set(episode_metrics(bare)) == set(EXPECTED) - missing


def test_torque_rate_of_one_step_does_not_exist() -> None:
    assert np.isnan(m.torque_rate(np.ones((2, 1, 3)), 0.1)).all()
