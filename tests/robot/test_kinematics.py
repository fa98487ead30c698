"""Poses, frames and Jacobians against printed matrices, Pinocchio and finite differences."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from prp_gym.robot import NOMINAL, PRPArm
from tests.support.pinocchio_model import Array, PinocchioArm, per_row, random_arm, random_states

PROPERTY = settings(max_examples=50, deadline=None, derandomize=True)
JOINTS = st.tuples(st.floats(-7.0, 7.0), st.floats(-1.0, 0.5), st.floats(-7.0, 7.0))
ARM = PRPArm()
A_1, SLIDE, A_3, HEIGHT = 0.40, 0.30, 0.24, 0.15
PI = math.pi
ROUNDING = 1e-14  # lengths and angles of order one, a few dozen operations
STEP = 1e-5  # of central differences: truncation and rounding both about 1e-11 ...
DIFFERENCE = 1e-9  # ... and hence this tolerance
SINGULAR = [
    (0.7, -0.1, PI / 2),
    (0.7, -0.1, -PI / 2),
    (-1.0, -SLIDE - A_3 * math.cos(0.4), 0.4),
    (-1.0, -SLIDE - A_3 * math.cos(2.0), 2.0),
    (0.3, -SLIDE, PI / 2),
]


def euler_zxz(alpha: float, beta: float, gamma: float) -> Array:
    """R_z(α) R_x(β) R_z(γ)."""

    def about_z(angle: float) -> Array:
        s, c = math.sin(angle), math.cos(angle)
        return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])

    s, c = math.sin(beta), math.cos(beta)
    rotation: Array = about_z(alpha) @ np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]]) @ about_z(gamma)
    return rotation


def printed_transforms(q: Array) -> Array:
    """The report's T_b^0 to T_b^4 with the garbled rows of T_b^4 put right."""
    s_1, c_1, s_3, c_3 = math.sin(q[0]), math.cos(q[0]), math.sin(q[2]), math.cos(q[2])
    slide = q[1] + SLIDE
    joint_3 = [slide * s_1 + A_1 * c_1, -slide * c_1 + A_1 * s_1, HEIGHT]
    tip = [joint_3[0] + A_3 * s_1 * c_3, joint_3[1] - A_3 * c_1 * c_3, HEIGHT + A_3 * s_3]
    last = [0.0, 0.0, 0.0, 1.0]
    return np.array(
        [
            [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, HEIGHT], last],
            [[c_1, 0, s_1, A_1 * c_1], [s_1, 0, -c_1, A_1 * s_1], [0, 1, 0, HEIGHT], last],
            [[0, -s_1, -c_1, joint_3[0]], [0, c_1, -s_1, joint_3[1]], [1, 0, 0, joint_3[2]], last],
            [
                [s_1 * c_3, -s_1 * s_3, -c_1, tip[0]],
                [-c_1 * c_3, c_1 * s_3, -s_1, tip[1]],
                [s_3, c_3, 0, tip[2]],
                last,
            ],
            [
                [-s_1 * s_3, -c_1, s_1 * c_3, tip[0]],
                [c_1 * s_3, -s_1, -c_1 * c_3, tip[1]],
                [c_3, 0, s_3, tip[2]],
                last,
            ],
        ]
    )


@pytest.mark.parametrize(
    ("joints", "pose"),
    [
        ((0, 0, 0), (0.4, -0.54, 0.15, 0, PI / 2, PI / 2)),
        ((0, -0.1, 0), (0.4, -0.44, 0.15, 0, PI / 2, PI / 2)),
        ((0, -0.2, 0), (0.4, -0.34, 0.15, 0, PI / 2, PI / 2)),
        ((0, -0.25, 0), (0.4, -0.29, 0.15, 0, PI / 2, PI / 2)),
        ((0, -0.3, 0), (0.4, -0.24, 0.15, 0, PI / 2, PI / 2)),
        ((-PI / 3, -0.1, PI / 2), (0.02679, -0.44641, 0.39, -1.0472, 0, PI / 2)),
        ((-PI / 2, -0.1, -PI / 6), (-0.40785, -0.4, 0.03, -1.5708, 2.0944, 1.5708)),
        ((-PI / 2, -0.2, -PI / 6), (-0.30785, -0.4, 0.03, -1.5708, 2.0944, 1.5708)),
    ],
)
def test_pose_at_the_reports_configurations(
    joints: tuple[float, float, float], pose: tuple[float, ...]
) -> None:
    # lengths printed with five decimals, angles with four
    tolerance = np.array([5.1e-6] * 3 + [5.1e-5] * 3)
    assert (np.abs(ARM.forward_kinematics(joints) - pose) < tolerance).all()


@pytest.mark.parametrize("seed", range(4))
def test_end_effector_frame_is_that_of_pinocchio(seed: int) -> None:
    parameters, other = random_arm(seed)
    q = random_states(seed, 50)[0]
    for arm, oracle in ((ARM, PinocchioArm()), (PRPArm(parameters), other)):
        expected = per_row(oracle.tip_transform, q)
        np.testing.assert_allclose(arm.transforms(q)[:, 4], expected, rtol=0, atol=ROUNDING)
        np.testing.assert_allclose(
            arm.forward_kinematics(q)[:, :3], expected[:, :3, 3], rtol=0, atol=ROUNDING
        )


def test_erratum_transforms_are_the_printed_ones_with_four_rows_each() -> None:
    q = random_states(1, 50)[0]
    transforms = ARM.transforms(q)
    assert transforms.shape == (50, 5, 4, 4)
    np.testing.assert_allclose(transforms, per_row(printed_transforms, q), rtol=0, atol=ROUNDING)


@PROPERTY
@given(joints=JOINTS)
def test_every_frame_is_a_rotation_and_a_translation(joints: tuple[float, float, float]) -> None:
    frames = ARM.transforms(joints)
    rotations = frames[:, :3, :3]
    identity = np.broadcast_to(np.eye(3), (5, 3, 3))
    np.testing.assert_allclose(rotations @ rotations.mT, identity, rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(np.linalg.det(rotations), np.ones(5), rtol=0, atol=ROUNDING)
    np.testing.assert_array_equal(frames[:, 3], np.broadcast_to([0.0, 0.0, 0.0, 1.0], (5, 4)))


@PROPERTY
@given(joints=JOINTS)
def test_pose_and_last_frame_tell_the_same_position_and_euler_angles(
    joints: tuple[float, float, float],
) -> None:
    pose, frame = ARM.forward_kinematics(joints), ARM.transforms(joints)[4]
    np.testing.assert_allclose(frame[:3, 3], pose[:3], rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(frame[:3, :3], euler_zxz(*pose[3:]), rtol=0, atol=ROUNDING)


@PROPERTY
@given(joints=JOINTS, turn=st.floats(-3.0, 3.0))
def test_turning_joint_1_turns_the_tip_about_the_vertical(
    joints: tuple[float, float, float], turn: float
) -> None:
    before = ARM.forward_kinematics(joints)
    after = ARM.forward_kinematics((joints[0] + turn, joints[1], joints[2]))
    np.testing.assert_allclose(after[:3], euler_zxz(turn, 0, 0) @ before[:3], rtol=0, atol=ROUNDING)


def test_erratum_joint_3_satisfies_the_quadratic_in_q2() -> None:
    q = random_states(2, 50)[0]
    x, y = ARM.transforms(q)[:, 2, :2, 3].T
    left = q[:, 1] ** 2 + 2 * SLIDE * q[:, 1] + A_1**2 + SLIDE**2 - x**2 - y**2
    np.testing.assert_allclose(left, np.zeros(50), rtol=0, atol=ROUNDING)


def test_analytical_jacobian_is_the_derivative_of_the_pose() -> None:
    q = random_states(3, 50)[0]
    for joint, step in enumerate(STEP * np.eye(3)):
        slope = (ARM.forward_kinematics(q + step) - ARM.forward_kinematics(q - step)) / (2 * STEP)
        np.testing.assert_allclose(ARM.analytical_jacobian(q)[..., joint], slope, rtol=0, atol=DIFFERENCE)


def test_geometric_jacobian_is_that_of_pinocchio() -> None:
    parameters, other = random_arm(5)
    q = random_states(4, 50)[0]
    for arm, oracle in ((ARM, PinocchioArm()), (PRPArm(parameters), other)):
        expected = per_row(oracle.tip_jacobian, q)
        np.testing.assert_allclose(arm.geometric_jacobian(q), expected, rtol=0, atol=ROUNDING)


def test_geometric_jacobian_is_built_from_axes_and_arms() -> None:
    q = random_states(5, 20)[0]
    frames, J_G = ARM.transforms(q), ARM.geometric_jacobian(q)
    axes, origins, tip = frames[:, :3, :3, 2], frames[:, :3, :3, 3], frames[:, 4, :3, 3]
    for joint in (0, 2):
        lever = np.cross(axes[:, joint], tip - origins[:, joint])
        np.testing.assert_allclose(J_G[:, :3, joint], lever, rtol=0, atol=ROUNDING)
        np.testing.assert_allclose(J_G[:, 3:, joint], axes[:, joint], rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(J_G[:, :3, 1], axes[:, 1], rtol=0, atol=ROUNDING)
    np.testing.assert_array_equal(J_G[:, 3:, 1], np.zeros((20, 3)))


def test_erratum_jacobians_have_cos_1_sin_3_in_the_row_of_p_y() -> None:
    q = random_states(6, 50)[0]
    expected = A_3 * np.cos(q[:, 0]) * np.sin(q[:, 2])
    for jacobian in (ARM.analytical_jacobian(q), ARM.geometric_jacobian(q)):
        np.testing.assert_allclose(jacobian[:, 1, 2], expected, rtol=0, atol=ROUNDING)


def test_euler_rate_map_turns_the_analytical_into_the_geometric_jacobian() -> None:
    q = random_states(7, 50)[0]
    product = ARM.euler_rate_map(q) @ ARM.analytical_jacobian(q)
    np.testing.assert_allclose(product, ARM.geometric_jacobian(q), rtol=0, atol=ROUNDING)


def test_euler_rate_map_has_rank_5_and_no_column_for_gamma() -> None:
    T_A = ARM.euler_rate_map(random_states(8, 20)[0])
    assert (np.linalg.matrix_rank(T_A) == 5).all()
    np.testing.assert_array_equal(T_A[..., 5], np.zeros((20, 6)))


@PROPERTY
@given(joints=JOINTS)
def test_determinant_of_the_position_part_is_minus_a3_c3_reach(joints: tuple[float, float, float]) -> None:
    reach = joints[1] + SLIDE + A_3 * math.cos(joints[2])
    determinant = np.linalg.det(ARM.analytical_jacobian(joints)[:3])
    assert determinant == pytest.approx(-A_3 * math.cos(joints[2]) * reach, rel=0, abs=ROUNDING)


@pytest.mark.parametrize("joints", SINGULAR)
def test_position_part_alone_is_singular_at_vertical_third_link_and_zero_reach(
    joints: tuple[float, float, float],
) -> None:
    smallest = np.linalg.svd(ARM.analytical_jacobian(joints)[:3], compute_uv=False)[-1]
    assert smallest < ROUNDING


@PROPERTY
@given(joints=st.one_of(JOINTS, st.sampled_from(SINGULAR)))
def test_analytical_jacobian_has_full_column_rank_everywhere(joints: tuple[float, float, float]) -> None:
    singular_values = np.linalg.svd(ARM.analytical_jacobian(joints), compute_uv=False)
    # the slide's column has norm 1 and the two angles have rows of their own: the least value of 400,000
    # random configurations of this range is 0.79
    assert singular_values[-1] > 0.75


def test_jacobian_derivative_is_the_slope_of_the_jacobian_along_a_motion() -> None:
    q, velocity, _, _ = random_states(9, 50)
    ahead, behind = (ARM.analytical_jacobian(q + sign * STEP * velocity) for sign in (1, -1))
    slope = (ahead - behind) / (2 * STEP)
    derivative = ARM.analytical_jacobian_derivative(q, velocity)
    # speeds up to 3 enter the truncation error with their third power
    np.testing.assert_allclose(derivative, slope, rtol=0, atol=30 * DIFFERENCE)


def test_erratum_jacobian_derivative_depends_on_velocities_only() -> None:
    q, velocity, _, _ = random_states(10, 50)
    derivative = ARM.analytical_jacobian_derivative(q, velocity)
    (s_1, _, s_3), (c_1, _, c_3) = np.sin(q).T, np.cos(q).T
    w_1, _, w_3 = velocity.T
    np.testing.assert_allclose(
        derivative[:, 0, 2], -A_3 * (c_1 * s_3 * w_1 + s_1 * c_3 * w_3), rtol=0, atol=ROUNDING
    )
    np.testing.assert_allclose(
        derivative[:, 1, 2], A_3 * (-s_1 * s_3 * w_1 + c_1 * c_3 * w_3), rtol=0, atol=ROUNDING
    )
    np.testing.assert_array_equal(derivative[:, 3:], np.zeros((50, 3, 3)))


def test_jacobian_and_its_derivative_give_the_acceleration_of_the_pose() -> None:
    q, velocity, acceleration, _ = random_states(11, 50)
    step = 1e-4  # of a second difference: truncation 1e-8 times speeds^4, rounding 1e-8

    def pose(time: float) -> Array:
        return ARM.forward_kinematics(q + time * velocity + 0.5 * time**2 * acceleration)

    measured = (pose(step) - 2 * pose(0.0) + pose(-step)) / step**2
    J_A, rate = ARM.analytical_jacobian(q), ARM.analytical_jacobian_derivative(q, velocity)
    expected = (J_A @ acceleration[..., None] + rate @ velocity[..., None])[..., 0]
    np.testing.assert_allclose(expected, measured, rtol=0, atol=2e-6)


def test_arms_are_equal_when_their_parameters_are() -> None:
    lighter = PRPArm(NOMINAL.with_masses((0.9, 0.5, 0.7)))
    assert PRPArm() == ARM
    assert hash(PRPArm()) == hash(ARM)
    assert lighter != ARM
    assert ARM != NOMINAL
    assert repr(lighter.parameters) in repr(lighter)
