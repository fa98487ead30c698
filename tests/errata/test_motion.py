"""Errata of the report in Coriolis forces, gravity, the equation of motion and its check."""

import dataclasses
from collections.abc import Callable

import numpy as np
import pytest

from prp_gym.robot import NOMINAL, REPORT, PRPArm
from tests.support.pinocchio_model import TABLE, Array, PinocchioArm, per_row, random_states

ARM, REPORT_ARM, PINOCCHIO = PRPArm(), PRPArm(REPORT), PinocchioArm()
A_1, SLIDE, A_3, H_3, R_3, HEIGHT = 0.40, 0.30, 0.24, 0.24, 0.02, 0.15
MASS_1, MASS_2, MASS_3 = NOMINAL.link_mass
EXACT = 1e-12  # a few dozen operations of 1e-16 on numbers of order one
STEP = 1e-5  # of central differences: truncation and rounding both about 1e-11 ...
DIFFERENCE = 1e-8  # ... times speeds up to 3, a few times over
Q, SPEED, _, _ = random_states(40, 50)
STILL = np.zeros(3)


def slide_slope(q: Array) -> Array:
    """X = ∂b_11/∂q_2 as printed."""
    return np.asarray(3.098 * q[..., 1] + 0.1962 * np.cos(q[..., 2]) + 0.7099)


def turn_slope(q: Array) -> Array:
    """Y = -∂b_11/∂q_3 as printed."""
    s_3, c_3 = np.sin(q[..., 2]), np.cos(q[..., 2])
    return np.asarray(0.0948 * s_3 * c_3 + 0.05885 * s_3 + 0.1962 * q[..., 1] * s_3)


def printed_coriolis(q: Array, v: Array) -> Array:
    """The c_ij of 3.1, symmetric as its stars say (..., 3, 3)."""
    s_3, c_3 = np.sin(q[..., 2]), np.cos(q[..., 2])
    X, Y = slide_slope(q), turn_slope(q)
    C = np.zeros((*q.shape, 3))
    C[..., 0, 0] = MASS_2 * (2 * SLIDE + 2 * q[..., 1] - 0.30) / 2 * v[..., 1]
    C[..., 0, 0] += MASS_3 * s_3 * c_3 * (A_3 * H_3 - A_3**2 - H_3**2 - R_3**2) * v[..., 2]
    C[..., 0, 1] = C[..., 1, 0] = 0.5 * v[..., 0] * v[..., 1] * X
    C[..., 0, 2] = C[..., 2, 0] = 0.03923 * c_3 * v[..., 2] ** 2 - 0.5 * v[..., 0] * Y * v[..., 2]
    return C


def printed_velocity_forces(q: Array, v: Array) -> Array:
    """What the printed equation of motion has beyond B q̈ and gravity (..., 3)."""
    c_3, X, Y = np.cos(q[..., 2]), slide_slope(q), turn_slope(q)
    w_1, v_2, w_3 = v[..., 0], v[..., 1], v[..., 2]
    forces = np.empty(q.shape)
    forces[..., 0] = w_1 * v_2**2 * X - w_1 * w_3**2 * Y + 0.03923 * c_3 * w_3**3
    forces[..., 1] = 0.5 * v_2 * X * w_1**2
    forces[..., 2] = w_1 * (0.03923 * c_3 * w_3**2 - 0.5 * w_1 * Y * w_3)
    return forces


def christoffel(arm: PRPArm, q: Array, v: Array) -> Array:
    """C(q, q̇) from central differences of an arm's inertia matrix (..., 3, 3)."""
    steps = STEP * np.eye(3)
    slope = [(arm.inertia_matrix(q + step) - arm.inertia_matrix(q - step)) / (2 * STEP) for step in steps]
    b = np.stack(slope, axis=-1)  # ∂b_ij/∂q_k
    symbols = 0.5 * (b + np.swapaxes(b, -1, -2) - np.moveaxis(b, -1, -3))
    return np.asarray((symbols @ v[..., None, :, None])[..., 0])


def rate_of_inertia(arm: PRPArm, q: Array, v: Array) -> Array:
    ahead, behind = arm.inertia_matrix(q + STEP * v), arm.inertia_matrix(q - STEP * v)
    return np.asarray((ahead - behind) / (2 * STEP))


def test_printed_coriolis_elements_are_not_linear_in_the_velocity() -> None:
    printed, doubled = printed_coriolis(Q, SPEED), printed_coriolis(Q, 2 * SPEED)
    np.testing.assert_allclose(doubled[:, 0, 1], 4 * printed[:, 0, 1], rtol=EXACT)
    np.testing.assert_allclose(doubled[:, 0, 2], 4 * printed[:, 0, 2], rtol=EXACT)
    right = ARM.coriolis_matrix(Q, SPEED)
    np.testing.assert_allclose(ARM.coriolis_matrix(Q, 2 * SPEED), 2 * right, rtol=EXACT)


def test_printed_coriolis_elements_are_not_the_symbols_of_the_printed_inertia() -> None:
    symbols = christoffel(REPORT_ARM, Q, SPEED)  # the report's own inertia: its errors do not enter here
    np.testing.assert_allclose(REPORT_ARM.coriolis_matrix(Q, SPEED), symbols, rtol=0, atol=DIFFERENCE)
    np.testing.assert_allclose(
        ARM.coriolis_matrix(Q, SPEED), christoffel(ARM, Q, SPEED), rtol=0, atol=DIFFERENCE
    )
    X, Y, coupling = slide_slope(Q), turn_slope(Q), MASS_3 * 0.12 * np.cos(Q[:, 2]) * SPEED[:, 2]
    w_1 = SPEED[:, 0]
    right = {
        (0, 0): (X * SPEED[:, 1] - Y * SPEED[:, 2]) / 2,
        (0, 1): X * w_1 / 2,
        (0, 2): A_1 * coupling - Y * w_1 / 2,
        (1, 0): -X * w_1 / 2,
        (1, 2): -coupling,
        (2, 0): Y * w_1 / 2,
    }
    printed = printed_coriolis(Q, SPEED)
    for (row, column), values in right.items():
        # the printed coefficients have four digits: up to 1e-4 times speeds of up to 3
        np.testing.assert_allclose(symbols[:, row, column], values, rtol=0, atol=5e-4)
        assert np.abs(printed[:, row, column] - values).max() > 0.1
    np.testing.assert_array_equal(symbols[:, [1, 2, 2], [1, 1, 2]], 0.0)
    # the slope of b_23 that is left out of ∂B/∂q_3, and hence c_23
    step = np.array([0.0, 0.0, STEP])
    slope = (REPORT_ARM.inertia_matrix(Q + step) - REPORT_ARM.inertia_matrix(Q - step))[:, 1, 2] / (2 * STEP)
    np.testing.assert_allclose(slope, -0.09808 * np.cos(Q[:, 2]), rtol=0, atol=5e-6)  # printed digits


def test_symmetric_coriolis_matrix_makes_energy_from_nothing() -> None:
    for matrix, conserves in (
        (REPORT_ARM.coriolis_matrix(Q, SPEED), True),
        (mirrored(REPORT_ARM.coriolis_matrix(Q, SPEED)), False),
        (printed_coriolis(Q, SPEED), False),
    ):
        N = rate_of_inertia(REPORT_ARM, Q, SPEED) - 2 * matrix
        skew = np.abs(N + N.mT).max(axis=(1, 2))
        power = 0.5 * (SPEED[:, None] @ N @ SPEED[..., None])[:, 0, 0]  # [W] that nothing supplies
        if conserves:
            assert skew.max() < 10 * DIFFERENCE
            assert np.abs(power).max() < 100 * DIFFERENCE  # speeds up to 5 enter with their square
        else:
            assert skew.min() > 0.01
            assert np.median(np.abs(power)) > 0.5


def mirrored(C: Array) -> Array:
    """C with its upper triangle below the diagonal too, and c_23 = 0."""
    C = C.copy()
    C[..., 1, 0], C[..., 2, 0] = C[..., 0, 1], C[..., 0, 2]
    C[..., 1, 2] = C[..., 2, 1] = 0.0
    return C


def test_printed_gravity_would_lift_the_third_link() -> None:
    printed = -0.9621 * np.cos(Q[:, 2])
    step = np.array([0.0, 0.0, STEP])
    # the potential energy that the report itself prints
    own = (0.9621 * np.sin((Q + step)[:, 2]) - 0.9621 * np.sin((Q - step)[:, 2])) / (2 * STEP)
    of_pinocchio = per_row(PINOCCHIO.gravity_vector, Q)
    for right in (own, of_pinocchio[:, 2], ARM.gravity_vector(Q)[:, 2]):
        np.testing.assert_allclose(right, -printed, rtol=0, atol=5e-5)  # its printed digits
        assert np.abs(right - printed).max() > 1.8
    # only link 3 and joint 3 have a term, so that the index of the sum's mass is of no effect
    np.testing.assert_allclose(of_pinocchio[:, :2], 0.0, rtol=0, atol=EXACT)
    # let go at home, the third link falls
    fall = ARM.forward_dynamics(STILL, STILL, STILL)[2]
    assert fall < 0 < np.linalg.solve(ARM.inertia_matrix(STILL), [0.0, 0.0, 0.9621])[2]
    assert fall == pytest.approx(PINOCCHIO.forward_dynamics(STILL, STILL, STILL, STILL)[2], rel=1e-10)


def check_arm() -> PRPArm:
    """The tensors of the report's check: as in its text, with m h²/4 twice and r² lost across the axis."""
    (axial_1, _, _), box, (_, axial_3, _) = REPORT.link_inertia
    masses = np.array([1.192, 0.7317, 0.8173])  # four digits, as run
    across_1, across_3 = 0.75 * masses[0] * 0.35**2, 0.75 * masses[2] * H_3**2
    inertia = ((axial_1, across_1, across_1), box, (across_3, axial_3, across_3))
    return PRPArm(dataclasses.replace(REPORT, link_mass=tuple(masses), link_inertia=inertia))


CHECK_SPEED = np.array([0.1, -0.1, 0.1])
PRINTED_MATRICES = [0.4372, 0.03208, 0.04708]  # b_11, b_13, b_33
PRINTED_RNE, PRINTED_L = [-0.001341, 0.0005088, -4.893e-5], [-0.001341, -0.001073, 0.0002748]


def test_check_matrices_are_those_of_one_configuration_with_columns_swapped() -> None:
    slide, turn = np.meshgrid(
        np.linspace(-0.2329, -0.2327, 201), np.linspace(0.9572, 0.9574, 101), indexing="ij"
    )
    q = np.stack([0 * slide, slide, turn], axis=-1)
    arm = check_arm()
    B, C, g = arm.inertia_matrix(q), arm.coriolis_matrix(q, CHECK_SPEED), arm.gravity_vector(q)
    found = [B[..., 0, 0], B[..., 0, 2], B[..., 2, 2], g[..., 2]]
    halves = [5e-5, 5e-6, 5e-6, 5e-5, 5e-7, 5e-7, 5e-8, 5e-7, 5e-8, 5e-9]  # half of each last digit
    # the true symbols, which Newton-Euler has to give, under "C_L"; the mirrored ones under "C_RNE"
    columns = [*np.moveaxis(C @ CHECK_SPEED, -1, 0), *np.moveaxis(mirrored(C) @ CHECK_SPEED, -1, 0)]
    printed = [*PRINTED_MATRICES, 0.5539, *PRINTED_L, *PRINTED_RNE]
    deviation = np.abs(np.stack([*found, *columns], axis=-1) - printed) / halves
    # ten printed numbers from two unknowns
    assert deviation.max(axis=-1).min() < 1.0
    best = np.unravel_index(deviation.max(axis=-1).argmin(), slide.shape)
    assert (slide[best], turn[best]) == pytest.approx((-0.2328, 0.9573), abs=1e-4)
    swept = arm.inverse_dynamics(q[best], CHECK_SPEED, STILL) - arm.gravity_vector(q[best])
    np.testing.assert_allclose(swept, PRINTED_L, rtol=0, atol=5e-7)
    assert np.abs(swept - PRINTED_RNE).max() > 1e-3


def test_printed_b23_of_the_check_is_impossible() -> None:
    q = random_states(41, 50)[0]
    for arm in (ARM, REPORT_ARM, check_arm()):
        B = arm.inertia_matrix(q)
        np.testing.assert_allclose(B[:, 1, 2] / B[:, 0, 2], -1 / A_1, rtol=EXACT)
    assert -0.06925 / 0.03208 > -2.2
    # nor does its sine fit the cosine of g_3, as that of b_13 does
    cosine = 0.5539 / 0.962145
    assert (0.03208 / 0.039231) ** 2 + cosine**2 == pytest.approx(1.0, abs=5e-4)  # four digits each
    assert (0.06925 / 0.098078) ** 2 + cosine**2 < 0.84


def test_right_numbers_of_the_check() -> None:
    q = np.array([0.4, -0.2328, 0.9573])  # nothing depends on q_1
    B, arm = PINOCCHIO.inertia_matrix(q), ARM.inertia_matrix(q)
    np.testing.assert_allclose(arm, B, rtol=0, atol=EXACT)
    # a configuration known to 1e-4 moves b_11 by 1e-5 and g_3 by 8e-5; then half of the last digit
    assert arm[0, 0] == pytest.approx(0.33499, abs=1.5e-5)
    assert arm[0, 2] == pytest.approx(0.03208, abs=1e-5)
    assert arm[1, 2] == pytest.approx(-0.0802, abs=1e-4)
    assert arm[2, 2] == pytest.approx(0.01577, abs=5.1e-6)
    assert ARM.gravity_vector(q)[2] == pytest.approx(0.5539, abs=1.3e-4)
    force = PINOCCHIO.coriolis_force(q, CHECK_SPEED)
    np.testing.assert_allclose(ARM.coriolis_matrix(q, CHECK_SPEED) @ CHECK_SPEED, force, rtol=0, atol=EXACT)
    # ∂²b_11/∂q_2² = 3.1 times 1e-4 m and two speeds of 0.1: 3.1e-6, half of it in the second row
    for row, (value, tolerance) in enumerate(((-0.0010466, 3.2e-6), (-0.0010735, 1.6e-6), (0.0001274, 2e-7))):
        assert force[row] == pytest.approx(value, abs=tolerance)


def test_printed_potential_energies_have_the_sign_of_depth() -> None:
    def printed(q: Array) -> tuple[float, float, Array]:
        height = HEIGHT + (A_3 - H_3 / 2) * np.sin(q[..., 2])
        return -MASS_1 * 9.81 * HEIGHT, -MASS_2 * 9.81 * HEIGHT, np.asarray(-MASS_3 * 9.81 * height)

    U_1, U_2, U_3 = printed(Q)
    of_pinocchio = per_row(PINOCCHIO.potential_energy, Q)
    np.testing.assert_allclose(U_1 + U_2 + U_3, -of_pinocchio, rtol=EXACT)
    step = np.array([0.0, 0.0, STEP])
    slope = (printed(Q + step)[2] - printed(Q - step)[2]) / (2 * STEP)
    gravity = per_row(PINOCCHIO.gravity_vector, Q)[:, 2]
    np.testing.assert_allclose(slope, -gravity, rtol=0, atol=DIFFERENCE)
    np.testing.assert_allclose(ARM.potential_energy(Q), of_pinocchio, rtol=EXACT)
    # U = -(U_1 + U_2 + U_3) has the second wrong sign: the printed sum is right again, to its four digits
    np.testing.assert_allclose(0.9621 * np.sin(Q[:, 2]) + 4.033, of_pinocchio, rtol=0, atol=5e-4)


def test_printed_equation_of_motion_has_forces_that_turn_with_the_direction_of_time() -> None:
    printed, reversed_ = printed_velocity_forces(Q, SPEED), printed_velocity_forces(Q, -SPEED)
    np.testing.assert_array_equal(reversed_, -printed)  # cubic in the velocities, like friction
    np.testing.assert_allclose(printed_velocity_forces(Q, 2 * SPEED), 8 * printed, rtol=EXACT)
    for arm in (ARM, REPORT_ARM):
        right = arm.inverse_dynamics(Q, SPEED, STILL) - arm.gravity_vector(Q)
        backwards = arm.inverse_dynamics(Q, -SPEED, STILL) - arm.gravity_vector(Q)
        np.testing.assert_allclose(backwards, right, rtol=0, atol=EXACT)
    X, Y = slide_slope(Q), turn_slope(Q)
    w_1, v_2, w_3 = SPEED.T
    spin = np.cos(Q[:, 2]) * w_3**2
    first = X * w_1 * v_2 - Y * w_1 * w_3 + 0.03923 * spin
    rows = [first, -0.5 * X * w_1**2 - 0.09808 * spin, 0.5 * Y * w_1**2]
    right = REPORT_ARM.inverse_dynamics(Q, SPEED, STILL) - REPORT_ARM.gravity_vector(Q)
    # four printed digits: up to 1e-4 times products of speeds up to 9
    np.testing.assert_allclose(np.stack(rows, axis=-1), right, rtol=0, atol=2e-3)
    assert np.abs(printed - right).max() > 1.0


def test_printed_equation_of_motion_is_unstable_under_the_reports_own_control() -> None:
    goal, step = np.array([np.pi / 2, -0.2, np.pi]), 1e-5

    def fastest(forces: Callable[[Array, Array], Array]) -> float:
        """Largest speed within 0.06 s from home under K_P = 50, K_D = 10 and compensated gravity."""
        q, v, largest = np.zeros(3), np.zeros(3), 0.0
        for _ in range(6000):
            push = 50 * (goal - q) - 10 * v - forces(q, v)
            v = v + step * np.linalg.solve(REPORT_ARM.inertia_matrix(q), push)
            q = q + step * v
            largest = max(largest, float(np.abs(v).max()))
            if largest > 1e4:
                break
        return largest

    assert fastest(printed_velocity_forces) > 1e4
    assert fastest(lambda q, v: REPORT_ARM.bias_force(q, v) - REPORT_ARM.gravity_vector(q)) < 40.0


def test_printed_gravity_of_newton_euler_is_that_of_a_base_that_falls_upwards() -> None:
    q = np.array([0.4, -0.2328, 0.9573])
    upside_down = PinocchioArm(dataclasses.replace(TABLE, gravity=-9.81))  # from p̈_0 + g_0
    swept = [arm.inverse_dynamics(q, STILL, STILL, STILL)[2] for arm in (PINOCCHIO, upside_down)]
    # 1e-4 rad of q_3 move it by 8e-5
    assert swept[1] == pytest.approx(-0.5539, abs=1.3e-4)
    assert swept[0] == pytest.approx(0.5539, abs=1.3e-4)
    assert ARM.inverse_dynamics(q, STILL, STILL)[2] == pytest.approx(swept[0], rel=EXACT)
