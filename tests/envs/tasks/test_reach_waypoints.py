"""`ReachWaypoints`: a path along a plane, as motions of the joints; rates, rests, and its distance."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from prp_gym.envs.tasks.force_position import ReachWaypoints
from prp_gym.robot import PRPArm
from prp_gym.robot.arrays import Array
from tests.support.pinocchio_model import PinocchioArm

SEEDS = st.integers(0, 2**32 - 1)
ARM = PRPArm()
STEP = 1e-5  # of finite differences [s]
SHORTEST = 0.8  # of the segments [s]
# Turns of up to 2 rad over 0.8 s have derivatives of at most 4.7 1/s, 18 1/s², 235 1/s³ and 1800 1/s⁴; those
# of a_3 cos q_3 add products of them, up to 3000 m/s³ and 20000 m/s⁴. Central differences err by STEP²/6 of
# them, and by a rounding of 1e-15 over STEP.
VELOCITY_TOLERANCE, ACCELERATION_TOLERANCE = 1e-7, 1e-6


def joints(rng: np.random.Generator, count: int = 4) -> Array:
    """(count, 3) within the joint limits."""
    return rng.uniform([-2.0, -0.3, -1.0], [2.0, 0.0, 1.0], size=(count, 3))


def times(rng: np.random.Generator, count: int = 4) -> Array:
    moments: Array = np.cumsum(rng.uniform(SHORTEST, 1.5, size=count))
    return moments


def along_a_plane(rng: np.random.Generator) -> tuple[ReachWaypoints, Array]:
    """A path whose q_1 and reach rest, and its waypoints (4, 3)."""
    waypoints = joints(rng)
    waypoints[:, 0] = waypoints[0, 0]
    reach = waypoints[0, 1] + 0.24 * np.cos(waypoints[0, 2])
    waypoints[:, 1] = reach - 0.24 * np.cos(waypoints[:, 2])
    return ReachWaypoints.through(ARM, times(rng)[None], waypoints[None]), waypoints


@given(SEEDS)
def test_rates_are_derivatives(seed: int) -> None:
    rng = np.random.default_rng(seed)
    path = ReachWaypoints.through(ARM, times(rng)[None], joints(rng)[None])
    inner = path.times[0, :-1] + rng.uniform(0.1, 0.9, size=(6, 3)) * np.diff(path.times[0])
    moments = np.concatenate([inner.ravel(), [0.0, path.times[0, -1] + 1.0]])[:, None]
    before, now, after = (path.sample(moments + shift) for shift in (-STEP, 0.0, STEP))
    change = (after - before) / (2 * STEP)
    np.testing.assert_allclose(now[..., 3:6], change[..., :3], rtol=0, atol=VELOCITY_TOLERANCE)
    np.testing.assert_allclose(now[..., 6:], change[..., 3:6], rtol=0, atol=ACCELERATION_TOLERANCE)


@given(SEEDS)
def test_tip_keeps_its_distance_from_the_plane(seed: int) -> None:
    rng = np.random.default_rng(seed)
    path, waypoints = along_a_plane(rng)
    moments = np.linspace(0.0, path.times[0, -1] + 1.0, 60)[:, None]
    motion = path.sample(moments)[:, 0]
    normal = np.array([np.sin(waypoints[0, 0]), -np.cos(waypoints[0, 0]), 0.0])
    oracle = PinocchioArm()
    tips = np.array([oracle.tip_transform(q)[:3, 3] for q in motion[:, :3]])
    # a few roundings of lengths below 1 m
    np.testing.assert_allclose(tips @ normal, tips[0] @ normal, rtol=0, atol=1e-12)
    _, velocity, acceleration = ARM.pose_motion(motion[:, :3], motion[:, 3:6], motion[:, 6:])
    # of speeds up to 2 m/s and accelerations up to 10 m/s²
    np.testing.assert_allclose(velocity[:, :3] @ normal, 0.0, atol=1e-12)
    np.testing.assert_allclose(acceleration[:, :3] @ normal, 0.0, atol=1e-12)
    assert np.ptp(tips[:, 2]) > 1e-3  # it moves along the plane


@given(SEEDS)
def test_waypoints_are_rests(seed: int) -> None:
    rng = np.random.default_rng(seed)
    moments, waypoints = times(rng), joints(rng)
    path = ReachWaypoints.through(ARM, moments[None], waypoints[None])
    values = path.sample(moments[:, None])[:, 0]
    # the reach comes and goes with a rounding of lengths below 1 m
    np.testing.assert_allclose(values[:, :3], waypoints, rtol=0, atol=1e-15)
    np.testing.assert_array_equal(values[:, 3:], 0.0)
    np.testing.assert_allclose(path.goal, waypoints[-1:], rtol=0, atol=1e-15)
    for moment, waypoint in ((moments[0] - 0.5, waypoints[0]), (moments[-1] + 9.0, waypoints[-1])):
        held = path.sample(np.array([moment]))[0]
        np.testing.assert_allclose(held[:3], waypoint, rtol=0, atol=1e-15)
        np.testing.assert_array_equal(held[3:], 0.0)


@given(SEEDS)
def test_joint_1_and_the_reach_are_the_quintics_between_waypoints(seed: int) -> None:
    rng = np.random.default_rng(seed)
    waypoints, share = joints(rng, 2), rng.uniform()
    path = ReachWaypoints.through(ARM, np.array([[1.0, 3.0]]), waypoints[None])
    q = path.sample(np.array([1.0 + 2.0 * share]))[0, :3]
    done = share**3 * (10 - 15 * share + 6 * share**2)
    reach = waypoints[:, 1] + 0.24 * np.cos(waypoints[:, 2])  # less d̄_2
    expected = [part[0] + done * (part[1] - part[0]) for part in (waypoints[:, 0], reach, waypoints[:, 2])]
    found = [q[0], q[1] + 0.24 * np.cos(q[2]), q[2]]
    # near the end of a segment the polynomial's terms, up to 15, nearly cancel, and turns are up to 4 rad
    np.testing.assert_allclose(found, expected, rtol=0, atol=4e-14)


def test_many_paths_side_by_side_are_each_on_its_own() -> None:
    rng = np.random.default_rng(4)
    moments, waypoints = np.stack([times(rng) for _ in range(3)]), np.stack([joints(rng) for _ in range(3)])
    together = ReachWaypoints.through(ARM, moments, waypoints)
    paths = [ReachWaypoints.through(ARM, moments[[row]], waypoints[[row]]) for row in range(3)]
    when = rng.uniform(0.0, 6.0, size=(7, 3))
    values = together.sample(when)
    assert values.shape == (7, 3, 9)
    for row, path in enumerate(paths):
        np.testing.assert_array_equal(values[:, row], path.sample(when[:, [row]])[:, 0])
        np.testing.assert_array_equal(together.rows(np.array([row])).goal, path.goal)
    together.assign(np.array([1]), paths[2])
    np.testing.assert_array_equal(together.sample(when)[:, 0], values[:, 0])
    np.testing.assert_array_equal(
        together.sample(when[:, [2, 2, 2]])[:, 1], paths[2].sample(when[:, [2]])[:, 0]
    )


@pytest.mark.parametrize("moved", [0, 1, 2])
def test_path_is_constant_if_all_waypoints_coincide(moved: int) -> None:
    waypoints = np.tile([0.3, -0.1, 0.4], (3, 1))
    moments = np.arange(1.0, 4.0)[None]
    assert ReachWaypoints.through(ARM, moments, waypoints[None]).is_constant
    waypoints[1, moved] += 0.01
    assert not ReachWaypoints.through(ARM, moments, waypoints[None]).is_constant


def test_waypoints_given_are_left_as_they_were() -> None:
    waypoints = joints(np.random.default_rng(1))
    copy = waypoints.copy()
    ReachWaypoints.through(ARM, np.arange(1.0, 5.0)[None], waypoints[None]).sample(np.array([1.5]))
    np.testing.assert_array_equal(waypoints, copy)
