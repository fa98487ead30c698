"""Metrics of joint motions on made-up ones whose values are known beforehand."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from prp_gym.evaluation.metrics import joint as m
from tests.support.synthetic_episodes import (
    GOAL,
    ROUNDING,
    SAMPLES,
    TIME,
    Array,
    assert_batch_equals_loop,
    jump,
    random_motions,
    reference,
)

CENTIMETRE = np.array([0.02, 0.01, 0.042])  # displacement of each joint for 1 cm at the tip


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
    move = np.linalg.norm(goal / CENTIMETRE)
    expected = 100.0 * 0.25 * abs(goal[2]) / CENTIMETRE[2] / move
    assert m.overshoot(actual, reference(goal)) == pytest.approx(expected, abs=1e2 * ROUNDING)


def test_overshoot_of_a_joint_that_hardly_moves_counts_as_it_moves_the_tip() -> None:
    goal = np.array([1.0, 0.01, 0.01])  # 50, 1 and 0.24 cm at the tip
    actual = jump(10, goal)
    actual[20, 2] = 0.02  # all of joint 3's own step, which is 0.24 cm of a move of 50 cm
    assert m.overshoot(actual, reference(goal)) == pytest.approx(0.476, abs=1e-3)


def test_overshoots_of_several_joints_at_one_time_add_up_as_displacements_do() -> None:
    actual = jump(10)
    actual[20] = 1.1 * GOAL
    assert m.overshoot(actual, reference()) == pytest.approx(10.0, abs=1e2 * ROUNDING)


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
    move = np.linalg.norm((GOAL - start) / CENTIMETRE)
    expected = 100.0 * (0.1 / CENTIMETRE[0]) / move
    assert m.overshoot(actual, reference()) == pytest.approx(expected, abs=1e2 * ROUNDING)


def test_joint_without_a_step_has_no_overshoot() -> None:
    goal = np.array([1.0, 1e-4, 0.0])  # joint 2 moves less than the resolution, joint 3 not at all
    actual = jump(10, goal)
    actual[20, 1:] = 0.5
    actual[30, 0] = 1.02
    assert m.overshoot(actual, reference(goal)) == pytest.approx(2.0, abs=1e2 * ROUNDING)
    assert np.isnan(m.overshoot(actual, reference(np.array([0.0, 1e-4, -1e-3]))))


def test_moving_reference_has_no_settling_time_nor_overshoot() -> None:
    desired = reference()
    desired[30, 1] += 1e-9
    assert np.isnan(m.settling_time(TIME, jump(10), desired))
    assert np.isnan(m.overshoot(jump(10), desired))


def test_robot_of_one_joint_has_the_band_and_the_resolution_of_the_first() -> None:
    goal = np.array([1e-3])  # within joint 1's 2 mrad; joint 2's 0.2 mm would tell it from the start
    assert m.settling_time(TIME, np.zeros((SAMPLES, 1)), reference(goal)) == 0.0
    assert np.isnan(m.overshoot(1.5 * reference(goal), reference(goal)))


def test_step_response_of_a_single_joint() -> None:
    actual = jump(10)[:, :1]
    actual[20] = 1.5 * GOAL[0]
    desired = reference(GOAL[:1])
    assert m.settling_time(TIME, actual, desired) == pytest.approx(TIME[21], abs=ROUNDING)
    assert m.overshoot(actual, desired) == pytest.approx(50.0, rel=ROUNDING)


BATCHED: dict[str, Callable[[Array, Array], NDArray[Any]]] = {
    "settling_time": lambda actual, desired: m.settling_time(TIME, actual, desired),
    "overshoot": m.overshoot,
}


@pytest.mark.parametrize("name", BATCHED)
@pytest.mark.parametrize("joints", [1, 3])
def test_batch_equals_a_loop_over_single_episodes(name: str, joints: int) -> None:
    actual, desired = random_motions(1, 2, 4)
    desired[0, 1, 50:] += 0.1  # a moving reference among constant ones
    actual[1, 2, -1] += 1.0  # and one that does not settle
    assert_batch_equals_loop(BATCHED[name], actual[..., :joints], desired[..., :joints])
