"""Motions of the joints and of the end effector, each from the other, against Pinocchio and differences."""

import numpy as np
import pytest
from numpy.typing import NDArray

from prp_gym.errors import ShapeError
from prp_gym.robot import PRPArm
from tests.support.control_interface import oracle_drift, oracle_jacobian, oracle_pose
from tests.support.pinocchio_model import PinocchioArm, random_arm, random_states

Array = NDArray[np.float64]

ARM, ORACLE = PRPArm(), PinocchioArm()
ROUNDING = 1e-12  # values up to 1e2, a few dozen operations of 1e-16 each


def path(time: float) -> Array:
    """A smooth motion of the joints through q_3 = ±π/2 and L = 0."""
    return np.array([0.4 + 0.9 * time, -0.15 + 0.1 * np.sin(2 * time), 1.0 + 2.0 * np.sin(1.3 * time)])


def path_motion(time: float) -> tuple[Array, Array, Array]:
    velocity = np.array([0.9, 0.2 * np.cos(2 * time), 2.6 * np.cos(1.3 * time)])
    acceleration = np.array([0.0, -0.4 * np.sin(2 * time), -3.38 * np.sin(1.3 * time)])
    return path(time), velocity, acceleration


def test_pose_motion_is_the_derivative_of_the_pose_of_a_path() -> None:
    h = 1e-4
    for time in np.linspace(0.0, 3.0, 31):
        before, now, after = (oracle_pose(ORACLE, path(time + step)) for step in (-h, 0.0, h))
        pose, velocity, acceleration = ARM.pose_motion(*path_motion(time))
        np.testing.assert_allclose(pose, now, atol=ROUNDING)
        # central differences over 1e-4 s: third and fourth derivatives, below 40, times h²/6 and h²/12,
        # and rounding of 1e-16 over h²
        np.testing.assert_allclose(velocity, (after - before) / (2 * h), atol=1e-7)
        np.testing.assert_allclose(acceleration, (after - 2 * now + before) / h**2, atol=2e-6)


def test_pose_motion_is_pinocchios_jacobian_times_the_motion() -> None:
    parameters, oracle = random_arm(3)
    arm = PRPArm(parameters)
    q, velocity, acceleration, _ = random_states(1, 20)
    pose, rate, curve = arm.pose_motion(q, velocity, acceleration)
    for row in range(20):
        J_A = oracle_jacobian(oracle, q[row])
        np.testing.assert_allclose(pose[row], oracle_pose(oracle, q[row]), atol=ROUNDING)
        np.testing.assert_allclose(rate[row], J_A @ velocity[row], atol=ROUNDING)
        expected = J_A @ acceleration[row] + oracle_drift(oracle, q[row], velocity[row])
        np.testing.assert_allclose(curve[row], expected, atol=1e-8)  # differences of the Jacobian


def test_joint_motion_undoes_pose_motion_on_every_turn() -> None:
    q, velocity, acceleration, _ = random_states(2, 200)
    q[:, [0, 2]] *= 3.0  # several turns
    back = ARM.joint_motion(*ARM.pose_motion(q, velocity, acceleration))
    for found, expected in zip(back, (q, velocity, acceleration), strict=True):
        # the normal equations square a condition number of below 2
        np.testing.assert_allclose(found, expected, rtol=1e-11, atol=1e-11)


@pytest.mark.parametrize("q_3", [np.pi / 2, -np.pi / 2, np.arccos(-0.2 / 0.24)])
def test_motion_passes_where_the_tip_s_position_alone_is_singular(q_3: float) -> None:
    q, velocity, acceleration = np.array([0.3, -0.1, q_3]), np.array([1.0, -0.5, 2.0]), np.ones(3)
    tip_rows = oracle_jacobian(ORACLE, q)[:3]
    assert abs(np.linalg.det(tip_rows)) < 1e-9
    back = ARM.joint_motion(*ARM.pose_motion(q, velocity, acceleration))
    for found, expected in zip(back, (q, velocity, acceleration), strict=True):
        np.testing.assert_allclose(found, expected, atol=1e-11)


def test_smallest_singular_value_of_the_jacobian_keeps_away_from_zero() -> None:
    q_2, q_3 = np.meshgrid(np.linspace(-0.3, 0.0, 61), np.linspace(-np.pi, np.pi, 181))
    q = np.stack([np.zeros(q_2.size), q_2.ravel(), q_3.ravel()], axis=-1)  # q_1 only turns the tip's rows
    jacobians = np.array([oracle_jacobian(ORACLE, row) for row in q[::7]])
    assert np.linalg.svd(jacobians, compute_uv=False).min() > 0.79
    np.testing.assert_allclose(ARM.analytical_jacobian(q[::7]), jacobians, atol=ROUNDING)


def test_pose_out_of_reach_keeps_its_angles_and_the_slide_comes_as_near_as_it_can() -> None:
    generator = np.random.default_rng(4)
    pose = np.array([oracle_pose(ORACLE, row) for row in random_states(5, 20)[0]])
    pose[:, :3] += generator.uniform(-0.5, 0.5, (20, 3))
    q = ARM.joint_position_of_pose(pose)
    np.testing.assert_array_equal(q[:, 0], pose[:, 3])
    np.testing.assert_allclose(np.pi / 2 - q[:, 2], pose[:, 4], atol=ROUNDING)

    def distance(slide: float) -> Array:
        moved = q + np.array([0.0, slide, 0.0])
        tips = np.array([oracle_pose(ORACLE, row)[:3] for row in moved])
        return np.asarray(np.linalg.norm(tips - pose[:, :3], axis=1))

    assert (distance(0.0) > 0.005).all()  # none is attained
    assert (distance(1e-3) > distance(0.0)).all()
    assert (distance(-1e-3) > distance(0.0)).all()


def test_motions_broadcast() -> None:
    q, velocity, acceleration, _ = (values.reshape(2, 5, 3) for values in random_states(6, 10))
    poses = ARM.pose_motion(q, velocity, acceleration)
    joints = ARM.joint_motion(*poses)
    assert {part.shape for part in poses} == {(2, 5, 6)}
    assert {part.shape for part in joints} == {(2, 5, 3)}
    single = ARM.pose_motion(q[1, 3], velocity[1, 3], acceleration[1, 3])
    for one, many in zip((*single, *ARM.joint_motion(*single)), (*poses, *joints), strict=True):
        np.testing.assert_allclose(one, many[1, 3], rtol=ROUNDING, atol=ROUNDING)


def test_vectors_of_another_size_are_refused() -> None:
    with pytest.raises(ShapeError, match="pose has shape"):
        ARM.joint_position_of_pose(np.zeros(3))
    with pytest.raises(ShapeError, match="velocity has shape"):
        ARM.joint_motion(np.zeros(6), np.zeros(3), np.zeros(6))
    with pytest.raises(ShapeError, match="acceleration has shape"):
        ARM.joint_motion(np.zeros(6), np.zeros(6), np.zeros(3))
    with pytest.raises(ShapeError, match="joint_acceleration has shape"):
        ARM.pose_motion(np.zeros(3), np.zeros(3), np.zeros(6))
