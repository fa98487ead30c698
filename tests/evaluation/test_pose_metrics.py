"""Metrics of the tip's motion on made-up motions whose values are known beforehand."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from prp_gym.evaluation import episode_metrics
from prp_gym.evaluation.metrics import pose as m
from tests.support.synthetic_episodes import (
    ROUNDING,
    SAMPLES,
    TIME,
    Array,
    assert_batch_equals_loop,
    make_rollout,
    pose,
    random_motions,
)

START = np.array([0.4, -0.54, 0.15])
GOAL = START + np.array([0.06, 0.0, -0.08])  # 0.1 m away, so that the band is 2 mm
ALONG = np.array([0.6, 0.0, -0.8])
ACROSS = np.array([0.8, 0.0, 0.6])


def goal(position: Array = GOAL) -> Array:
    return np.tile(position, (SAMPLES, 1))


def arrival(sample: int, residue: Array = 0.0 * GOAL, start: Array = START) -> Array:
    """At the start before a sample; from it on at the goal but for a residue [m]."""
    return np.where(np.arange(SAMPLES)[:, None] < sample, start, GOAL + residue)


@pytest.mark.parametrize(
    ("residue", "settles"),
    [
        (1.9e-3 * ALONG, True),
        (-1.9e-3 * ALONG, True),
        (1.9e-3 * ACROSS, True),
        (2.1e-3 * ACROSS, False),
        (np.array([1.5e-3, 1.5e-3, 0.0]), False),  # each coordinate within 2 mm, the distance not
    ],
)
def test_tip_settles_within_two_percent_of_its_way_in_every_direction(residue: Array, settles: bool) -> None:
    time = m.position_settling_time(TIME, arrival(30, residue), goal())
    assert time == pytest.approx(TIME[30] if settles else np.inf, abs=ROUNDING)


def test_tip_settles_when_it_has_entered_for_good() -> None:
    actual = arrival(30)
    actual[70] = START
    assert m.position_settling_time(TIME, actual, goal()) == pytest.approx(TIME[71], abs=ROUNDING)


@pytest.mark.parametrize(("residue", "settles"), [(1.9e-4, True), (2.1e-4, False)])
def test_band_of_the_tip_is_never_below_the_resolution(residue: float, settles: bool) -> None:
    near = GOAL - 1e-3 * ALONG  # 2 % of 1 mm would be 20 µm
    time = m.position_settling_time(TIME, arrival(30, residue * ACROSS, near), goal())
    assert time == pytest.approx(TIME[30] if settles else np.inf, abs=ROUNDING)


def test_overshoot_of_the_tip_is_its_excess_along_the_way() -> None:
    actual = arrival(10)
    actual[20] = GOAL + 0.025 * ALONG + 0.5 * ACROSS
    actual[30] = GOAL - 0.2 * ALONG
    # rounding of 0.1 m and of the way's direction, times 100 %
    assert m.position_overshoot(actual, goal()) == pytest.approx(25.0, rel=1e-10)


@pytest.mark.parametrize("residue", [-0.01 * ALONG, 0.05 * ACROSS])
def test_what_falls_short_or_passes_by_is_no_overshoot(residue: Array) -> None:
    assert m.position_overshoot(arrival(10, residue), goal()) == pytest.approx(0.0, abs=1e-10)


def test_tip_that_starts_at_its_goal_has_no_overshoot() -> None:
    near = GOAL - 1.9e-4 * ALONG
    far = GOAL - 2.1e-4 * ALONG
    assert np.isnan(m.position_overshoot(arrival(10, 0.1 * ALONG, near), goal()))
    assert m.position_overshoot(arrival(10, 0.1 * ALONG, far), goal()) > 0.0
    assert np.isnan(m.position_overshoot(goal(), goal()))


def test_steady_state_error_is_the_norm_of_the_mean_and_not_the_mean_of_the_norm() -> None:
    actual = arrival(10)
    actual[-10:] += np.array([0.003, 0.0, -0.004])
    actual[-10:] += 0.02 * (-1.0) ** np.arange(10)[:, None]
    actual[-11] = 7.0  # before the last tenth of 101 samples
    assert m.position_steady_state_error(actual, goal()) == pytest.approx(0.005, rel=1e-10)


def test_moving_reference_has_neither_settling_time_nor_overshoot_nor_steady_error() -> None:
    late, early = goal(), goal()
    late[-3, 1] += 1e-9
    early[30, 1] += 0.1
    for desired in (late, early):
        assert np.isnan(m.position_settling_time(TIME, arrival(10), desired))
        assert np.isnan(m.position_overshoot(arrival(10), desired))
    assert np.isnan(m.position_steady_state_error(arrival(10), late))
    assert m.position_steady_state_error(arrival(10), early) == 0.0


def test_turning_reference_leaves_the_metrics_of_the_position_alone() -> None:
    turning = pose(goal(), np.stack([TIME, 0.5 * TIME], axis=-1))
    actual = pose(arrival(40), np.zeros((SAMPLES, 2)))
    values = episode_metrics(make_rollout({"end_effector_pose": actual, "desired_pose": turning}))
    np.testing.assert_allclose(values["position_settling_time"], [TIME[40]], rtol=ROUNDING)
    np.testing.assert_allclose(values["position_overshoot"], [0.0], atol=1e-10)
    np.testing.assert_allclose(values["orientation_maximum_error"], [np.sqrt(1.25)], rtol=ROUNDING)


def test_angle_a_turn_away_is_an_error() -> None:
    desired = pose(goal(), np.zeros((SAMPLES, 2)))
    actual = pose(goal(), np.tile([2.0 * np.pi, 0.0], (SAMPLES, 1)))
    values = episode_metrics(make_rollout({"end_effector_pose": actual, "desired_pose": desired}))
    np.testing.assert_allclose(values["orientation_rmse"], [2.0 * np.pi], rtol=ROUNDING)


def test_third_angle_and_desired_pose_do_not_enter_the_comparison_with_the_model() -> None:
    actual = pose(goal(), np.zeros((SAMPLES, 2)))
    model = actual.copy()
    model[:, 5] += 1.0
    model[50] += [0.1, 0.2, -0.2, 0.03, -0.04, 0.0]
    fields = {"end_effector_pose": actual, "model_pose": model, "desired_pose": actual + 1.0}
    values = episode_metrics(make_rollout(fields))
    np.testing.assert_allclose(values["model_position_rmse"], [0.3 / np.sqrt(SAMPLES)], rtol=1e-10)
    np.testing.assert_allclose(values["model_orientation_rmse"], [0.05 / np.sqrt(SAMPLES)], rtol=1e-10)
    np.testing.assert_allclose(values["model_maximum_error"], [0.3], rtol=1e-10)


BATCHED: dict[str, Callable[[Array, Array], NDArray[Any]]] = {
    "position_settling_time": lambda actual, desired: m.position_settling_time(TIME, actual, desired),
    "position_overshoot": m.position_overshoot,
    "position_steady_state_error": m.position_steady_state_error,
}


@pytest.mark.parametrize("name", BATCHED)
def test_batch_equals_a_loop_over_single_episodes(name: str) -> None:
    actual, desired = random_motions(1, 2, 4)
    desired[0, 1, 50:] += 0.1  # a moving reference among constant ones
    actual[1, 2, -1] += 1.0  # and one that does not settle
    actual[1, 3] = desired[1, 3]  # and one without a step
    assert_batch_equals_loop(BATCHED[name], actual, desired)
