"""Errata of the report in kinematics: the printed formulas are wrong, those of the arm are right."""

import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

from prp_gym.robot import PRPArm, to_urdf
from tests.support.pinocchio_model import Array, PinocchioArm, per_row, random_states

ARM, PINOCCHIO = PRPArm(), PinocchioArm()
A_1, A_2, SLIDE, A_3, HEIGHT = 0.40, 0.30, 0.30, 0.24, 0.15
ROUNDING = 1e-12  # lengths and angles of order one, a few dozen operations of 1e-16, inverses of up to 100
STEP = 1e-5  # of central differences: truncation and rounding both about 1e-11 ...
DIFFERENCE = 3e-8  # ... times speeds up to 3, three times over
COUNT = 50
Q, SPEED, ACCELERATION, _ = random_states(20, COUNT)
S_1, C_1, S_3, C_3 = np.sin(Q[:, 0]), np.cos(Q[:, 0]), np.sin(Q[:, 2]), np.cos(Q[:, 2])
U = Q[:, 1] + SLIDE
L = U + A_3 * C_3
ZERO = np.zeros(COUNT)


def matrices(rows: list[list[Array]]) -> Array:
    """(COUNT, rows, columns) from entries (COUNT)."""
    return np.moveaxis(np.array(rows), -1, 0)


def slope_of_pose(joint: int) -> Array:
    """∂x/∂q_joint by central differences, (COUNT, 6)."""
    step = STEP * np.eye(3)[joint]
    difference: Array = ARM.forward_kinematics(Q + step) - ARM.forward_kinematics(Q - step)
    return difference / (2 * STEP)


def about_z(angle: Array) -> Array:
    s, c = np.sin(angle), np.cos(angle)
    zero, one = 0 * s, 0 * s + 1
    return matrices([[c, -s, zero], [s, c, zero], [zero, zero, one]])


def about_x(angle: Array) -> Array:
    s, c = np.sin(angle), np.cos(angle)
    zero, one = 0 * s, 0 * s + 1
    return matrices([[one, zero, zero], [zero, c, -s], [zero, s, c]])


def zxz(angles: Array) -> Array:
    """R_z(α) R_x(β) R_z(γ)."""
    return about_z(angles[:, 0]) @ about_x(angles[:, 1]) @ about_z(angles[:, 2])


def random_angles() -> Array:
    return np.random.default_rng(21).uniform(-3.0, 3.0, size=(COUNT, 3))


def test_printed_last_transform_has_one_row_too_many() -> None:
    tip = [L * S_1 + A_1 * C_1, -L * C_1 + A_1 * S_1, HEIGHT + A_3 * S_3]
    first, last = [-S_1 * S_3, -C_1, S_1 * C_3, tip[0]], [ZERO, ZERO, ZERO, ZERO + 1]
    stray, second = [S_1 * S_3, -S_1, -C_1 * C_3, tip[1]], [C_1 * S_3, -S_1, -C_1 * C_3, tip[1]]
    third = [C_3, ZERO, S_3, tip[2]]
    printed = matrices([first, stray, second, third, last])
    assert printed.shape == (COUNT, 5, 4)
    right = ARM.transforms(Q)[:, 4]
    np.testing.assert_allclose(np.delete(printed, 1, axis=1), right, rtol=0, atol=ROUNDING)
    # the other of the two rows that look alike does not make a rotation
    kept = np.delete(printed, 2, axis=1)[:, :3, :3]
    excess = np.abs(kept @ kept.mT - np.eye(3)).max(axis=(1, 2))
    assert (excess[np.abs(S_1 - C_1) > 0.1] > 1e-3).all()
    np.testing.assert_allclose(right, per_row(PINOCCHIO.tip_transform, Q), rtol=0, atol=ROUNDING)


def test_printed_row_of_p_y_is_not_the_slope_of_p_y() -> None:
    slope = slope_of_pose(2)[:, 1]
    for printed in (A_3 * S_1 * S_3, A_3 * C_1 * C_3):  # the gradient in 1.4; J_G in 1.5
        assert np.abs(printed - slope).max() > 0.1
    of_pinocchio = per_row(PINOCCHIO.tip_jacobian, Q)[:, 1, 2]
    for right in (ARM.analytical_jacobian(Q)[:, 1, 2], ARM.geometric_jacobian(Q)[:, 1, 2]):
        np.testing.assert_allclose(right, A_3 * C_1 * S_3, rtol=0, atol=ROUNDING)
        np.testing.assert_allclose(right, slope, rtol=0, atol=DIFFERENCE)
        np.testing.assert_allclose(right, of_pinocchio, rtol=0, atol=ROUNDING)


def test_printed_quadratic_and_its_solution_miss_the_slide() -> None:
    axis_3 = ARM.transforms(Q)[:, 2, :2, 3]  # where frame 2 has its origin
    distance = (axis_3**2).sum(axis=-1)
    printed = Q[:, 1] ** 2 + 2 * SLIDE * Q[:, 1] + A_2 - distance
    np.testing.assert_allclose(printed, A_2 - A_1**2 - SLIDE**2, rtol=0, atol=ROUNDING)  # 0.05, not 0
    constant = A_1**2 + SLIDE**2 - distance
    right = Q[:, 1] ** 2 + 2 * SLIDE * Q[:, 1] + constant
    np.testing.assert_allclose(right, 0.0, rtol=0, atol=ROUNDING)
    # A read as 4 and d̄_2' as d̄_2²: the printed quotient has 2 d̄_2² below the line, where 2 belongs
    half = np.sign(U) * np.sqrt(4 * SLIDE**2 - 4 * constant)
    printed_root = -(2 * SLIDE - half) / (2 * SLIDE**2)
    # a small reach takes the square root of the rounding
    np.testing.assert_allclose(printed_root, Q[:, 1] / SLIDE**2, rtol=0, atol=1e-6)  # 11 times too far
    right_root = -SLIDE + np.sign(U) * np.sqrt(distance - A_1**2)
    np.testing.assert_allclose(right_root, Q[:, 1], rtol=0, atol=1e-8)


def test_printed_jacobian_derivative_takes_accelerations_for_velocities() -> None:
    def formula(slide: Array, turn: Array) -> Array:
        """Printed with q̈_2, q̈_3 instead of q̇_2, q̇_3; its sixth row is missing."""
        w_1 = SPEED[:, 0]
        rate = slide - A_3 * S_3 * turn
        return matrices(
            [
                [
                    rate * C_1 - (L * S_1 + A_1 * C_1) * w_1,
                    C_1 * w_1,
                    -A_3 * (C_1 * S_3 * w_1 + S_1 * C_3 * turn),
                ],
                [
                    rate * S_1 + (L * C_1 - A_1 * S_1) * w_1,
                    S_1 * w_1,
                    A_3 * (C_1 * C_3 * turn - S_1 * S_3 * w_1),
                ],
                [ZERO, ZERO, -A_3 * S_3 * turn],
                [ZERO] * 3,
                [ZERO] * 3,
            ]
        )

    ahead, behind = (ARM.analytical_jacobian(Q + sign * STEP * SPEED) for sign in (1, -1))
    slope = (ahead - behind) / (2 * STEP)
    printed = formula(ACCELERATION[:, 1], ACCELERATION[:, 2])
    assert printed.shape[1] == 5
    assert np.abs(printed - slope[:, :5]).max() > 0.5
    right = ARM.analytical_jacobian_derivative(Q, SPEED)
    assert right.shape == (COUNT, 6, 3)
    np.testing.assert_allclose(right, slope, rtol=0, atol=DIFFERENCE)
    np.testing.assert_allclose(right[:, :5], formula(SPEED[:, 1], SPEED[:, 2]), rtol=0, atol=ROUNDING)
    # an arm that starts from rest has a Jacobian at rest; the printed one moves already
    np.testing.assert_array_equal(ARM.analytical_jacobian_derivative(Q, 0 * SPEED), 0.0)
    assert np.abs(printed[:, 2, 2]).max() > 0.1


def test_arm_is_not_prismatic_revolute_prismatic() -> None:
    spins = np.linalg.norm(ARM.geometric_jacobian(Q)[:, 3:], axis=1)  # of each joint, (COUNT, 3)
    np.testing.assert_allclose(spins, np.tile([1.0, 0.0, 1.0], (COUNT, 1)), rtol=0, atol=ROUNDING)
    joints = ElementTree.fromstring(to_urdf()).findall("joint")[:3]
    assert "".join(str(joint.get("type"))[0].upper() for joint in joints) == "RPR"


def test_tip_position_does_not_determine_the_position_of_joint_3() -> None:
    q = np.array([0.3, -0.2, 1.2])
    joints, valid = ARM.inverse_kinematics_branches(ARM.forward_kinematics(q)[:3])
    attained = joints[valid]
    assert len(attained) >= 2
    tips = ARM.forward_kinematics(attained)[:, :3]
    np.testing.assert_allclose(tips, np.tile(tips[0], (len(tips), 1)), rtol=0, atol=ROUNDING)
    axis_3 = ARM.transforms(attained)[:, 2, :3, 3]
    # p_2, from which the report computes q_2, is another in each: 2 a_3 C_3 apart in the first two
    assert np.linalg.norm(axis_3[0] - axis_3[1]) == pytest.approx(2 * A_3 * np.cos(1.2), abs=ROUNDING)
    # with the orientation it is known: joint 3 lies a_3 behind the tip along the approach axis
    frames = ARM.transforms(attained)
    np.testing.assert_allclose(frames[:, 4, :3, 3] - A_3 * frames[:, 4, :3, 2], axis_3, rtol=0, atol=ROUNDING)


def test_printed_sine_of_q1_is_undefined_at_the_end_of_the_slide() -> None:
    def printed(x: float, y: float, u: float) -> float:
        cosine = (A_1 * x - u * y) / (u**2 + A_1**2)
        return (x - A_1 * cosine) / u

    def right(x: float, y: float, u: float) -> float:
        return (A_1 * y + u * x) / (u**2 + A_1**2)

    for u, bearable in ((0.3, True), (1e-15, False)):
        x, y, _ = ARM.transforms([0.7, u - SLIDE, 0.4])[2, :3, 3]
        assert right(x, y, u) == pytest.approx(np.sin(0.7), abs=1e-14)
        assert (abs(printed(x, y, u) - np.sin(0.7)) < 1e-14) == bearable
    with pytest.raises(ZeroDivisionError):
        printed(A_1 * float(np.cos(0.7)), A_1 * float(np.sin(0.7)), 0.0)
    # the report's x_0 of 11 and 12 is such a point; here it is given by its joint position
    at_end = np.array([0.0, -0.3, 0.0])
    found = ARM.inverse_kinematics(ARM.forward_kinematics(at_end)[:3], at_end)
    np.testing.assert_allclose(found, at_end, rtol=0, atol=1e-8)


def test_printed_euler_matrix_is_no_rotation() -> None:
    angles = random_angles()
    (s_a, s_b, s_g), (c_a, c_b, c_g) = np.sin(angles).T, np.cos(angles).T
    middle = c_b * c_g * c_a

    def generic(entry: Array) -> Array:
        return matrices(
            [
                [c_a * c_g - c_b * s_a * s_g, -c_a * s_g - c_b * c_g * s_a, s_a * s_b],
                [s_a * c_g + c_b * c_a * s_g, entry, -c_a * s_b],
                [s_b * s_g, c_g * s_b, c_b],
            ]
        )

    printed, right = generic(-s_a * s_g - middle), generic(-s_a * s_g + middle)
    np.testing.assert_allclose(right, zxz(angles), rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(right @ right.mT, np.tile(np.eye(3), (COUNT, 1, 1)), rtol=0, atol=ROUNDING)
    excess = np.abs(printed @ printed.mT - np.eye(3)).max(axis=(1, 2))
    assert (excess[np.abs(middle) > 0.05] > 1e-3).all()
    assert (np.abs(middle) > 0.05).sum() > COUNT / 2
    # nothing follows for this arm: at γ = π/2 the entry is -S_α either way
    np.testing.assert_allclose(ARM.transforms(Q)[:, 4, 1, 1], -S_1, rtol=0, atol=ROUNDING)


def test_printed_euler_rate_map_loses_the_turn_about_the_approach_axis() -> None:
    pose = ARM.forward_kinematics(Q)
    (s_a, s_b, _), (c_a, c_b, _) = np.sin(pose[:, 3:]).T, np.cos(pose[:, 3:]).T
    one = ZERO + 1
    full = matrices([[ZERO, c_a, s_a * s_b], [ZERO, s_a, -c_a * s_b], [one, ZERO, c_b]])
    rates = np.random.default_rng(22).uniform(-1.0, 1.0, size=(COUNT, 3))
    ahead, behind = (zxz(pose[:, 3:] + sign * STEP * rates) for sign in (1, -1))
    spin = (ahead - behind) @ zxz(pose[:, 3:]).mT / (2 * STEP)  # S(ω)
    measured = np.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]], axis=-1)
    np.testing.assert_allclose((full @ rates[..., None])[..., 0], measured, rtol=0, atol=DIFFERENCE)
    printed = ARM.euler_rate_map(Q)[:, 3:, 3:]
    assert np.abs((printed @ rates[..., None])[..., 0] - measured).max() > 0.5
    np.testing.assert_array_equal(printed[..., 2], 0.0)
    approach = ARM.transforms(Q)[:, 4, :3, 2]
    np.testing.assert_allclose(full[..., 2], approach, rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(np.linalg.det(full), -np.sin(pose[:, 4]), rtol=0, atol=ROUNDING)
    # on the motions of this arm, whose γ is constant, either serves ...
    angular = ARM.geometric_jacobian(Q)[:, 3:]
    for T in (printed, full):
        np.testing.assert_allclose(T @ ARM.analytical_jacobian(Q)[:, 3:], angular, rtol=0, atol=ROUNDING)
    # ... but u = T_A^T h has no γ component, whatever moment h has about the approach axis
    np.testing.assert_allclose((approach[:, None] @ full)[:, 0, 2], 1.0, rtol=0, atol=ROUNDING)
    np.testing.assert_array_equal((approach[:, None] @ printed)[:, 0, 2], 0.0)


def test_analytical_jacobian_has_no_inverse_but_a_pseudoinverse() -> None:
    J_A = ARM.analytical_jacobian(Q)
    with pytest.raises(np.linalg.LinAlgError):
        np.linalg.inv(J_A[0])
    B, B_A = ARM.inertia_matrix(Q), ARM.operational_space_dynamics(Q, SPEED).inertia
    assert B_A.shape == (COUNT, 6, 6)
    assert (np.linalg.matrix_rank(B_A, tol=1e-6) == 3).all()
    np.testing.assert_allclose(J_A.mT @ B_A @ J_A, B, rtol=0, atol=ROUNDING)
