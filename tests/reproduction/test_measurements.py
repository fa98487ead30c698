"""Measurements and signals of the reproduction on rollouts made by hand."""

from typing import Any

import numpy as np
import pytest

from prp_gym.errors import InvalidValueError, UnknownNameError
from prp_gym.evaluation import Rollout
from prp_gym.reproduction.measurements import MEASUREMENTS
from prp_gym.reproduction.signals import SIGNALS, series
from tests.support.synthetic_rollout import PERIOD, rollout_of


def measure(name: str, rollout: Rollout, signal: str, **arguments: Any) -> list[float]:
    found: list[float] = MEASUREMENTS[name](rollout, signal, **arguments).tolist()
    return found


def error_rollout(*columns: list[float]) -> Rollout:
    """Joint errors column by column, against a desired position of 1."""
    error = np.array(columns).T
    return rollout_of({"desired_joint_position": np.ones_like(error), "joint_position": 1.0 - error})


FORCES = rollout_of({"contact_force": np.array([[0, 0, 0], [1, -5, 0], [3, -2, 0], [2, -1, 0], [2, 0.5, 0]])})


@pytest.mark.parametrize(
    ("name", "arguments", "expected"),
    [
        ("value_at", {"time": 0.2}, [3, -2, 0]),
        ("value_at", {"time": 0.2, "components": [1]}, [-2]),
        ("value_at", {"time": 0.2 + 1e-9, "components": [1, 0]}, [-2, 3]),
        ("value_at", {"time": 0.0}, [0, 0, 0]),
        ("final_value", {}, [2, 0.5, 0]),
        ("final_value", {"components": [0]}, [2]),
        ("maximum", {}, [3, 0.5, 0]),
        ("maximum", {"until": 0.1, "components": [0]}, [1]),
        ("time_of_maximum", {}, [0.2, 0.4, 0.0]),
        ("time_of_maximum", {"until": 0.1, "components": [0]}, [0.1]),
        ("values_at", {"times": [0.2, 0.1], "components": [0, 1]}, [3, -2, 1, -5]),
        ("minimum", {}, [0, -5, 0]),
        ("minimum", {"after": 0.2, "components": [1]}, [-2]),
        ("largest_magnitude", {}, [3, 5, 0]),
        ("largest_magnitude", {"after": 0.2}, [3, 2, 0]),
        ("root_mean_square", {"after": 0.3}, [2, np.sqrt(0.625), 0]),
        ("root_mean_square", {"components": [0]}, [np.sqrt(18 / 5)]),
    ],
)
def test_measurements_of_a_signal(name: str, arguments: dict[str, Any], expected: list[float]) -> None:
    assert measure(name, FORCES, "contact_force", **arguments) == pytest.approx(expected, abs=1e-12)


def test_step_responses_are_measured_joint_by_joint() -> None:
    # to 1 and 20 % beyond; to -2 and not beyond, settled late; never within the band
    rollout = error_rollout(
        [1.0, 0.5, -0.2, 0.01, 0.0, 0.0],
        [-2.0, -1.0, -0.5, -0.1, -0.03, -0.02],
        [1.0, 0.9, 0.9, 0.9, 0.9, 0.9],
    )
    assert measure("overshoot", rollout, "joint_error") == pytest.approx([20.0, 0.0, 0.0])
    assert measure("peak_time", rollout, "joint_error") == pytest.approx([0.2, 0.5, 0.1])
    assert measure("settling_time", rollout, "joint_error") == pytest.approx([0.3, 0.4, np.inf])


def test_step_response_ends_where_it_is_told_to() -> None:
    rollout = error_rollout([1.0, 0.5, -0.1, 0.0, -0.9, -0.9])
    assert measure("overshoot", rollout, "joint_error", until=0.3) == pytest.approx([10.0])
    assert measure("overshoot", rollout, "joint_error") == pytest.approx([90.0])
    assert measure("peak_time", rollout, "joint_error", until=0.3) == pytest.approx([0.2])
    assert measure("settling_time", rollout, "joint_error", until=0.3) == pytest.approx([0.3])


def test_error_that_starts_at_nothing_has_no_response() -> None:
    rollout = error_rollout([1.0, 0.5, 0.0], [0.0, 0.1, 0.0])
    with pytest.raises(InvalidValueError, match="first value of 'joint_error'"):
        measure("settling_time", rollout, "joint_error")
    assert measure("overshoot", rollout, "joint_error", components=[0]) == [0.0]


def test_small_steps_count_like_large_ones() -> None:
    shape = np.array([1.0, -0.25, 0.01, 0.0])
    rollout = error_rollout([*shape], [*(1e-5 * shape)])  # below what the joints' metrics take for a step
    assert measure("overshoot", rollout, "joint_error") == pytest.approx([25.0, 25.0])
    assert measure("settling_time", rollout, "joint_error") == pytest.approx([0.2, 0.2])


def test_responses_that_differ_only_in_size_have_no_spread() -> None:
    shape = np.array([1.0, 0.4, -0.1, 0.0])
    rollout = error_rollout([*shape], [*(-3 * shape)], [*(0.2 * shape)])
    assert measure("spread_of_responses", rollout, "joint_error") == pytest.approx([0.0], abs=1e-12)
    other = error_rollout([1.0, 0.4, -0.1, 0.0], [1.0, 0.4, 0.2, 0.0])
    assert measure("spread_of_responses", other, "joint_error") == pytest.approx([0.3])


def test_second_order_response_deviates_from_itself_by_nothing() -> None:
    time = np.arange(31) * PERIOD
    decay = np.exp(-5 * time) * (np.cos(5 * time) + np.sin(5 * time))  # K_P = 50, K_D = 10
    rollout = error_rollout([*(2 * decay)], [*(decay + np.where(time > 0, 0.1, 0.0))])
    gains = {"proportional_gain": 50.0, "derivative_gain": 10.0}
    found = measure("deviation_from_second_order", rollout, "joint_error", **gains)
    assert found == pytest.approx([0.0, 0.1 * np.sqrt(30 / 31)], abs=1e-12)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_decay_rate_is_that_of_the_distance_from_the_target(sign: float) -> None:
    time = np.arange(41) * PERIOD
    rollout = rollout_of({"contact_force": np.outer(1.0 + sign * 0.3 * np.exp(-0.7 * time), [0, 1, 0])})
    found = measure("decay_rate", rollout, "contact_force", target=1.0, start=1.0, stop=3.0, components=[1])
    assert found == pytest.approx([0.7], abs=1e-9)


def test_states_that_are_unknown_at_first_do_not_hide_the_extremes() -> None:
    rollout = rollout_of({"parameter_estimate": [[np.nan] * 3, [0.5, 0.1, 1.9], [0.6, 0.2, 1.8]]})
    assert measure("maximum", rollout, "parameter_estimate") == [0.6, 0.2, 1.9]
    assert measure("minimum", rollout, "parameter_estimate") == [0.5, 0.1, 1.8]


def test_errors_are_desired_minus_actual() -> None:
    pose, desired, model = np.arange(12.0).reshape(2, 6), np.full((2, 6), 3.0), np.full((2, 6), 5.0)
    rollout = rollout_of({"end_effector_pose": pose, "desired_pose": desired, "model_pose": model})
    np.testing.assert_array_equal(series(rollout, "pose_error")[1], desired - pose)
    np.testing.assert_array_equal(series(rollout, "model_error", [2, 0])[1], (model - pose)[:, [2, 0]])


def test_torques_stand_at_the_start_of_their_period() -> None:
    rollout = rollout_of({"joint_position": np.zeros((3, 3))}, torque=[[1, 2, 3], [4, 5, 6]])
    time, values = series(rollout, "torque", [1])
    np.testing.assert_allclose(time, [0.0, PERIOD])
    np.testing.assert_array_equal(values, [[2.0], [5.0]])
    assert measure("value_at", rollout, "torque", time=0.0) == [1.0, 2.0, 3.0]
    assert measure("final_value", rollout, "torque") == [4.0, 5.0, 6.0]


def test_what_a_rollout_does_not_have_is_refused() -> None:
    link = rollout_of({"joint_position": [[0.0], [1.0]]})
    with pytest.raises(UnknownNameError, match="joint_position"):
        series(link, "joint_positions")
    with pytest.raises(InvalidValueError, match="contact_force"):
        series(link, "contact_force")
    with pytest.raises(InvalidValueError, match="desired_joint_position"):
        series(link, "joint_error")
    with pytest.raises(InvalidValueError, match="component of 'joint_position' is 1"):
        series(link, "joint_position", [1])
    with pytest.raises(InvalidValueError, match="measured interval"):
        measure("value_at", link, "joint_position", time=0.5)


def test_every_signal_has_a_unit_for_each_symbol() -> None:
    for signal in SIGNALS.values():
        assert len(signal.symbols) == len(signal.units) > 0
        assert all(symbol.startswith("$") and symbol.endswith("$") for symbol in signal.symbols)
        assert len(signal.difference) in (0, 2)
