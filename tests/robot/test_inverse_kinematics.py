"""Inverse kinematics: it undoes forward kinematics, finds all branches and says why it cannot."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from prp_gym.errors import NonFiniteError, ShapeError, UnreachableError
from prp_gym.robot import NOMINAL, PRPArm, RobotParameters
from prp_gym.robot.inverse_kinematics import branches
from tests.support.pinocchio_model import Array, PinocchioArm, per_row

PROPERTY = settings(max_examples=50, deadline=None, derandomize=True)
PI = math.pi
A_1, SLIDE, A_3, HEIGHT = 0.40, 0.30, 0.24, 0.15
ARM = PRPArm()
LONG_SLIDE = PRPArm(dataclasses.replace(NOMINAL, joint_lower=(-PI, -3.0, -PI), joint_upper=(PI, 3.0, PI)))
LOWER, UPPER = np.array(NOMINAL.joint_lower), np.array(NOMINAL.joint_upper)
ROUNDING = 1e-13  # square roots near zero lose a digit against the rounding of forward kinematics
ALLOWED = 2e-9  # [m]: how far a solution may miss its point, plus how far it is pulled back to a limit
WITHIN_LIMITS = st.tuples(st.floats(-PI, PI), st.floats(-0.3, 0.0), st.floats(-PI, PI))
CORNERS = st.tuples(
    st.sampled_from([-PI, -PI / 2, 0.0, PI / 2, PI]),
    st.sampled_from([-0.3, -0.1, 0.0]),
    st.sampled_from([-PI, -PI / 2, 0.0, PI / 2, PI]),
)


def reachable_points(seed: int, count: int) -> tuple[Array, Array]:
    """Random joint positions within the limits, and where Pinocchio puts their tips."""
    q = np.random.default_rng(seed).uniform(LOWER, UPPER, size=(count, 3))
    return q, per_row(PinocchioArm().tip_transform, q)[:, :3, 3]


def distance_to_workspace(point: Array) -> float:
    """From a point to the nearest attainable one [m], in the half-plane through joint 1's axis."""
    angle = np.linspace(-PI, PI, 200_001)
    end = SLIDE + A_3 * np.cos(angle)
    least, most = end - 0.3, end
    near = np.where(least * most <= 0.0, 0.0, np.minimum(np.abs(least), np.abs(most)))
    far = np.maximum(np.abs(least), np.abs(most))
    radius = np.clip(np.hypot(point[0], point[1]), np.hypot(A_1, near), np.hypot(A_1, far))
    height = HEIGHT + A_3 * np.sin(angle)
    return float(np.hypot(radius - np.hypot(point[0], point[1]), height - point[2]).min())


def test_solution_attains_the_point_within_the_limits() -> None:
    q, points = reachable_points(0, 500)
    solution = ARM.inverse_kinematics(points, q)
    attained = per_row(PinocchioArm().tip_transform, solution)[:, :3, 3]
    np.testing.assert_allclose(attained, points, rtol=0, atol=ROUNDING)
    assert (solution >= LOWER).all()
    assert (solution <= UPPER).all()


def test_seed_at_a_solution_brings_that_solution_back() -> None:
    q, points = reachable_points(1, 500)
    # where cos q_3 or the reach is near zero an error of the point grows by its inverse
    np.testing.assert_allclose(ARM.inverse_kinematics(points, q), q, rtol=0, atol=1e-10)


@PROPERTY
@given(joints=st.one_of(WITHIN_LIMITS, CORNERS))
def test_every_point_within_the_limits_has_a_solution_that_attains_it(
    joints: tuple[float, float, float],
) -> None:
    point = ARM.forward_kinematics(joints)[:3]
    solution = ARM.inverse_kinematics(point, joints)
    np.testing.assert_allclose(ARM.forward_kinematics(solution)[:3], point, rtol=0, atol=ALLOWED)
    assert (solution >= LOWER).all()
    assert (solution <= UPPER).all()


def test_all_four_branches_attain_the_point_when_the_slide_is_long() -> None:
    _, points = reachable_points(2, 200)
    joints, valid = LONG_SLIDE.inverse_kinematics_branches(points)
    assert joints.shape == (200, 4, 3)
    assert valid.all()
    attained = LONG_SLIDE.forward_kinematics(joints)[..., :3]
    np.testing.assert_allclose(attained, np.broadcast_to(points[:, None], (200, 4, 3)), rtol=0, atol=ROUNDING)


def test_branches_are_ordered_by_the_signs_of_cos_3_and_reach() -> None:
    _, points = reachable_points(3, 200)
    joints, _ = LONG_SLIDE.inverse_kinematics_branches(points)
    cos_3 = np.cos(joints[..., 2])
    reach = joints[..., 1] + SLIDE + A_3 * cos_3
    np.testing.assert_array_equal(np.sign(cos_3), np.tile([1, 1, -1, -1], (200, 1)))
    np.testing.assert_array_equal(np.sign(reach), np.tile([1, -1, 1, -1], (200, 1)))


def test_branches_outside_the_limits_are_marked_and_kept() -> None:
    _, points = reachable_points(4, 200)
    joints, valid = ARM.inverse_kinematics_branches(points)
    inside = ((joints >= LOWER - 1e-9) & (joints <= UPPER + 1e-9)).all(axis=-1)
    np.testing.assert_array_equal(valid, inside)
    assert valid.any(axis=-1).all()
    assert not valid.all(axis=-1).any()  # the slide is too short for all four
    attained = ARM.forward_kinematics(joints)[..., :3]
    np.testing.assert_allclose(attained, np.broadcast_to(points[:, None], (200, 4, 3)), rtol=0, atol=ROUNDING)


def test_chosen_branch_is_the_nearest_to_the_seed_in_fractions_of_the_ranges() -> None:
    _, points = reachable_points(5, 200)
    seeds = np.random.default_rng(6).uniform(LOWER, UPPER, size=(200, 3))
    chosen = ARM.inverse_kinematics(points, seeds)
    joints, valid = ARM.inverse_kinematics_branches(points)
    fractions = (joints - seeds[:, None]) / (UPPER - LOWER)
    distances = np.where(valid, np.linalg.norm(fractions, axis=-1), np.inf)
    mine = np.linalg.norm((chosen - seeds) / (UPPER - LOWER), axis=-1)
    np.testing.assert_allclose(mine, distances.min(axis=-1), rtol=0, atol=ROUNDING)
    assert len(np.unique(distances.argmin(axis=-1))) > 2  # the seeds do choose


def test_seed_chooses_between_both_elbows() -> None:
    point = ARM.forward_kinematics((0.0, -0.15, 1.5))[:3]
    up = ARM.inverse_kinematics(point, (0.0, -0.15, 1.5))
    # the same point with the third link pointing back and the slide further out
    expected = (0.0, -0.15 + 2 * A_3 * math.cos(1.5), PI - 1.5)
    back = ARM.inverse_kinematics(point, expected)
    # the inverse of cos 1.5 = 0.07 multiplies rounding
    np.testing.assert_allclose(up, (0.0, -0.15, 1.5), rtol=0, atol=1e-12)
    np.testing.assert_allclose(back, expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize(("height", "angle"), [(1.0, PI / 2), (-1.0, -PI / 2)])
def test_raw_branches_ignore_the_limits_and_give_the_nearest_real_root(height: float, angle: float) -> None:
    joints = branches(ARM, np.array([0.1, 0.0, height]))
    reach = joints[:, 1] + SLIDE + A_3 * np.cos(joints[:, 2])
    np.testing.assert_allclose(reach, np.zeros(4), rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(joints[:, 2], np.full(4, angle), rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("height", [HEIGHT + A_3 + 0.06, HEIGHT - A_3 - 0.06])
def test_point_above_or_below_the_reach_names_the_height_and_the_residual(height: float) -> None:
    point = (0.4, -0.2, height)  # 0.06 m beyond a point that the slide's range allows
    with pytest.raises(UnreachableError) as caught:
        ARM.inverse_kinematics(point, np.zeros(3))
    assert caught.value.position == point
    assert caught.value.residual == pytest.approx(0.06, rel=0, abs=ROUNDING)
    assert caught.value.broken == (f"height {height:g} m is not within 0.24 m of 0.15 m",)
    for part in (f"(0.4, -0.2, {height:g}) m", "misses it by 0.06 m", *caught.value.broken):
        assert part in str(caught.value)


def test_point_near_joint_1s_axis_names_the_distance_and_the_residual() -> None:
    with pytest.raises(UnreachableError) as caught:
        ARM.inverse_kinematics((0.1, 0.0, HEIGHT), np.zeros(3))
    assert caught.value.residual == pytest.approx(A_1 - 0.1, rel=0, abs=ROUNDING)
    assert caught.value.broken == ("distance 0.1 m from joint 1's axis is below 0.4 m",)
    assert "misses it by 0.3 m; broken: distance 0.1 m" in str(caught.value)


@pytest.mark.parametrize("past", [0.01, 0.26])
def test_point_past_the_end_of_the_slide_names_the_limit(past: float) -> None:
    point = (A_1, -(SLIDE + A_3 + past), HEIGHT)
    with pytest.raises(UnreachableError) as caught:
        ARM.inverse_kinematics(point, np.zeros(3))
    assert caught.value.broken == (f"joint 2 would be {past:g} m, allowed -0.3 to 0 m",)
    # no configuration is nearer than the workspace, and holding the other joints it is `past` away
    least = distance_to_workspace(np.array(point))
    assert least - 1e-6 <= caught.value.residual <= past + ROUNDING
    assert f"misses it by {caught.value.residual:.6g} m" in str(caught.value)


def test_limit_of_a_joint_that_turns_is_named_with_its_unit() -> None:
    narrow = PRPArm(dataclasses.replace(NOMINAL, joint_lower=(-0.5, -0.3, -PI), joint_upper=(0.5, 0.0, PI)))
    point = ARM.forward_kinematics((0.6, -0.1, 0.3))[:3]
    with pytest.raises(UnreachableError, match=r"joint 1 would be 0.6 rad, allowed -0.5 to 0.5 rad"):
        narrow.inverse_kinematics(point, np.zeros(3))


@pytest.mark.parametrize("point", [(0.4, -0.8, 0.15), (0.4, -0.5, 0.45)])
def test_residual_is_attained_and_no_less_than_the_distance_to_the_workspace(
    point: tuple[float, float, float],
) -> None:
    with pytest.raises(UnreachableError) as caught:
        ARM.inverse_kinematics(point, np.zeros(3))
    low, high = np.array(ARM.parameters.joint_lower), np.array(ARM.parameters.joint_upper)
    clipped = np.clip(branches(ARM, np.array(point)), low, high)
    misses = np.linalg.norm(ARM.forward_kinematics(clipped)[..., :3] - point, axis=-1)
    assert caught.value.residual == misses.min()
    # the grid of `distance_to_workspace` is 3e-5 rad wide
    assert caught.value.residual >= distance_to_workspace(np.array(point)) - 1e-5


def test_a_point_that_is_not_finite_is_refused_as_such() -> None:
    with pytest.raises(NonFiniteError, match="tip_position"):
        ARM.inverse_kinematics((0.4, np.nan, 0.15), np.zeros(3))


def test_joint_ranges_beyond_a_half_turn_are_served() -> None:
    arm = PRPArm(RobotParameters(joint_lower=(0.0, -0.3, 0.0), joint_upper=(2 * np.pi, 0.0, 2 * np.pi)))
    q = np.array([4.0, -0.1, 5.5])
    solution = arm.inverse_kinematics(arm.forward_kinematics(q)[:3], q)
    np.testing.assert_allclose(solution, q, rtol=0, atol=ROUNDING)


def test_one_unreachable_point_of_many_is_the_one_reported() -> None:
    points = reachable_points(7, 6)[1].reshape(2, 3, 3)
    points[1, 0] = (0.1, 0.0, HEIGHT)
    with pytest.raises(UnreachableError) as caught:
        ARM.inverse_kinematics(points, np.zeros(3))
    assert caught.value.position == (0.1, 0.0, HEIGHT)
    _, valid = ARM.inverse_kinematics_branches(points)
    np.testing.assert_array_equal(valid.any(axis=-1), [[True, True, True], [False, True, True]])


@pytest.mark.parametrize("leading", [(), (5,), (2, 3)])
def test_one_seed_serves_many_points(leading: tuple[int, ...]) -> None:
    points = np.broadcast_to(ARM.forward_kinematics((0.2, -0.1, 0.4))[:3], (*leading, 3))
    solution = ARM.inverse_kinematics(points, (0.2, -0.1, 0.4))
    assert solution.shape == (*leading, 3)
    expected = np.broadcast_to([0.2, -0.1, 0.4], (*leading, 3))
    np.testing.assert_allclose(solution, expected, rtol=0, atol=ROUNDING)


def test_many_seeds_serve_one_point() -> None:
    seeds = np.array([[0.2, -0.1, 0.4], [0.1, -0.2, 0.5]])
    point = ARM.forward_kinematics((0.2, -0.1, 0.4))[:3]
    assert ARM.inverse_kinematics(point, seeds).shape == (2, 3)


@pytest.mark.parametrize("shape", [(), (2,), (3, 4)])
def test_wrong_shapes_are_refused_by_name(shape: tuple[int, ...]) -> None:
    with pytest.raises(ShapeError, match="tip_position"):
        ARM.inverse_kinematics_branches(np.zeros(shape))
    with pytest.raises(ShapeError, match="tip_position"):
        ARM.inverse_kinematics(np.zeros(shape), np.zeros(3))
    with pytest.raises(ShapeError, match="seed"):
        ARM.inverse_kinematics((0.4, -0.4, HEIGHT), np.zeros(shape))
