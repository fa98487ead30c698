"""Inertia, Coriolis, gravity and energies against Pinocchio, the report's numbers and conservation laws."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from prp_gym.robot import NOMINAL, REPORT, PRPArm
from tests.support.pinocchio_model import Array, PinocchioArm, per_row, random_arm, random_states

PROPERTY = settings(max_examples=50, deadline=None, derandomize=True)
JOINTS = st.tuples(st.floats(-7.0, 7.0), st.floats(-0.8, 0.4), st.floats(-7.0, 7.0))
SPEEDS = st.tuples(*[st.floats(-5.0, 5.0)] * 3)
ARM, REPORT_ARM = PRPArm(), PRPArm(REPORT)
FRICTION = dataclasses.replace(NOMINAL, viscous_friction=(0.5, 2.0, 0.1), coulomb_friction=(0.3, 1.5, 0.05))
PINOCCHIO = PinocchioArm()
ROUNDING = 1e-12  # forces and energies up to about 50, a few dozen operations of 1e-16 each
STEP = 1e-5  # of central differences: truncation and rounding both about 1e-11 ...
DIFFERENCE = 1e-9  # ... and hence this tolerance, per unit of speed
TIME_STEP = 5e-4  # [s]
SIX_DECIMALS = 5.1e-7  # half of the last printed digit
MODELS = [
    (ARM, PINOCCHIO),
    *((PRPArm(parameters), oracle) for parameters, oracle in map(random_arm, range(4))),
]
NAMES = ["nominal", "random_0", "random_1", "random_2", "random_3"]
EVERY_ARM = pytest.mark.parametrize(("arm", "oracle"), MODELS, ids=NAMES)
CHECK = (0.4, -0.2328, 0.9573)  # the configuration of the report's check matrices; any q_1
CHECK_SPEED = (0.1, -0.1, 0.1)


@EVERY_ARM
def test_inertia_matrix_is_that_of_pinocchio(arm: PRPArm, oracle: PinocchioArm) -> None:
    q = random_states(0, 50)[0]
    expected = per_row(oracle.inertia_matrix, q)
    np.testing.assert_allclose(arm.inertia_matrix(q), expected, rtol=0, atol=ROUNDING)


@EVERY_ARM
def test_coriolis_force_is_that_of_pinocchio(arm: PRPArm, oracle: PinocchioArm) -> None:
    q, velocity, _, _ = random_states(1, 50)
    force = (arm.coriolis_matrix(q, velocity) @ velocity[..., None])[..., 0]
    np.testing.assert_allclose(force, per_row(oracle.coriolis_force, q, velocity), rtol=0, atol=ROUNDING)


@EVERY_ARM
def test_gravity_is_that_of_pinocchio_and_the_slope_of_the_potential(
    arm: PRPArm, oracle: PinocchioArm
) -> None:
    q = random_states(2, 50)[0]
    gravity = arm.gravity_vector(q)
    np.testing.assert_allclose(gravity, per_row(oracle.gravity_vector, q), rtol=0, atol=ROUNDING)
    for joint, step in enumerate(STEP * np.eye(3)):
        slope = (arm.potential_energy(q + step) - arm.potential_energy(q - step)) / (2 * STEP)
        # the potential is up to 40 J, whose rounding the difference divides by the step
        np.testing.assert_allclose(gravity[:, joint], slope, rtol=0, atol=5 * DIFFERENCE)


@EVERY_ARM
def test_energies_are_those_of_pinocchio(arm: PRPArm, oracle: PinocchioArm) -> None:
    q, velocity, _, _ = random_states(3, 50)
    kinetic = per_row(oracle.kinetic_energy, q, velocity)
    np.testing.assert_allclose(arm.kinetic_energy(q, velocity), kinetic, rtol=0, atol=ROUNDING)
    potential = per_row(oracle.potential_energy, q)
    np.testing.assert_allclose(arm.potential_energy(q), potential, rtol=0, atol=ROUNDING)


@EVERY_ARM
def test_forward_dynamics_is_that_of_pinocchio(arm: PRPArm, oracle: PinocchioArm) -> None:
    q, velocity, torque, force = random_states(4, 50)
    expected = per_row(oracle.forward_dynamics, q, velocity, torque, force)
    # the condition number of B, up to 500, multiplies the rounding
    np.testing.assert_allclose(
        arm.forward_dynamics(q, velocity, torque, force), expected, rtol=1e-11, atol=1e-11
    )


def test_coriolis_matrix_is_built_from_christoffel_symbols_of_the_first_kind() -> None:
    q, velocity, _, _ = random_states(5, 20)
    slope = np.empty((20, 3, 3, 3))  # ∂b_ij/∂q_k, from Pinocchio's inertia matrix
    for joint, step in enumerate(STEP * np.eye(3)):
        above, below = (
            per_row(PINOCCHIO.inertia_matrix, q + step),
            per_row(PINOCCHIO.inertia_matrix, q - step),
        )
        slope[..., joint] = (above - below) / (2 * STEP)
    symbols = 0.5 * (slope + np.einsum("nikj->nijk", slope) - np.einsum("njki->nijk", slope))
    expected = np.einsum("nijk,nk->nij", symbols, velocity)
    np.testing.assert_allclose(ARM.coriolis_matrix(q, velocity), expected, rtol=0, atol=10 * DIFFERENCE)


@PROPERTY
@given(joints=JOINTS, speeds=SPEEDS)
def test_rate_of_b_minus_twice_c_is_skew_symmetric(
    joints: tuple[float, float, float], speeds: tuple[float, float, float]
) -> None:
    q, velocity = np.array(joints), np.array(speeds)
    ahead, behind = ARM.inertia_matrix(q + STEP * velocity), ARM.inertia_matrix(q - STEP * velocity)
    N = (ahead - behind) / (2 * STEP) - 2 * ARM.coriolis_matrix(q, velocity)
    # the third power of the speed, up to 9 in norm, multiplies the truncation error
    np.testing.assert_allclose(N, -N.T, rtol=0, atol=100 * DIFFERENCE)


@PROPERTY
@given(joints=JOINTS, turn=st.floats(-3.0, 3.0))
def test_inertia_matrix_is_symmetric_positive_definite_and_blind_to_joint_1(
    joints: tuple[float, float, float], turn: float
) -> None:
    B = ARM.inertia_matrix(joints)
    np.testing.assert_array_equal(B, B.T)
    assert np.linalg.eigvalsh(B)[0] > 0
    np.testing.assert_array_equal(B, ARM.inertia_matrix((joints[0] + turn, joints[1], joints[2])))


@PROPERTY
@given(joints=JOINTS, speeds=SPEEDS, factor=st.floats(-3.0, 3.0))
def test_coriolis_matrix_is_linear_in_the_velocity(
    joints: tuple[float, float, float], speeds: tuple[float, float, float], factor: float
) -> None:
    scaled = ARM.coriolis_matrix(joints, factor * np.array(speeds))
    np.testing.assert_allclose(scaled, factor * ARM.coriolis_matrix(joints, speeds), rtol=0, atol=ROUNDING)


def polynomial_of_b_11(arm: PRPArm) -> Array:
    """Coefficients of b_11 for 1, q_2, q_2², C_3², C_3, q_2 C_3."""
    q = random_states(6, 20)[0]
    slide, cosine = q[:, 1], np.cos(q[:, 2])
    terms = np.stack([np.ones(20), slide, slide**2, cosine**2, cosine, slide * cosine], axis=-1)
    fit: Array = np.linalg.lstsq(terms, arm.inertia_matrix(q)[:, 0, 0])[0]
    np.testing.assert_allclose(terms @ fit, arm.inertia_matrix(q)[:, 0, 0], rtol=0, atol=ROUNDING)
    return fit


def test_printed_numbers_of_the_inertia_matrix() -> None:
    printed = (0.403534, 0.709900, 1.549017, 0.015611, 0.058847, 0.196156)
    np.testing.assert_allclose(polynomial_of_b_11(ARM), printed, rtol=0, atol=SIX_DECIMALS)
    B = ARM.inertia_matrix((0.0, 0.0, math.pi / 2))  # S_3 = 1
    expected = (-0.619607, 0.039231, 1.549017, -0.098078, 0.015774)
    found = (B[0, 1], B[0, 2], B[1, 1], B[1, 2], B[2, 2])
    np.testing.assert_allclose(found, expected, rtol=0, atol=SIX_DECIMALS)


def test_printed_numbers_of_gravity_and_potential_energy() -> None:
    assert ARM.gravity_vector(np.zeros(3))[2] == pytest.approx(0.962145, rel=0, abs=SIX_DECIMALS)
    level, raised = ARM.potential_energy([[0.0, 0.0, 0.0], [0.0, 0.0, math.pi / 2]])
    assert level == pytest.approx(4.033289, rel=0, abs=SIX_DECIMALS)
    assert raised - level == pytest.approx(0.962145, rel=0, abs=SIX_DECIMALS)


def test_report_preset_reproduces_the_reports_wrong_inertia_numbers() -> None:
    coefficients = polynomial_of_b_11(REPORT_ARM)
    b_33 = REPORT_ARM.inertia_matrix(np.zeros(3))[2, 2]
    # each within half of the last digit that the report prints
    assert coefficients[0] == pytest.approx(0.496, rel=0, abs=5e-4)
    assert coefficients[3] == pytest.approx(0.0474, rel=0, abs=5e-5)
    assert b_33 == pytest.approx(0.04757, rel=0, abs=5e-6)
    # what the wrong tensors do not enter is right: 1.549, 0.7099, 0.05885, 0.1962 printed
    np.testing.assert_allclose(coefficients[[1, 2, 4, 5]], polynomial_of_b_11(ARM)[[1, 2, 4, 5]], rtol=1e-9)


def test_report_preset_reproduces_the_printed_kinetic_energy() -> None:
    across, along = (0.0, 0.0, math.pi / 2), (0.0, 0.0, 0.0)  # C_3 = 0 and 1, at q_2 = 0
    first, third = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)
    constant = REPORT_ARM.kinetic_energy(across, first)
    assert constant == pytest.approx(0.248, rel=0, abs=5e-4)
    even = (REPORT_ARM.kinetic_energy(along, first) + REPORT_ARM.kinetic_energy((0, 0, math.pi), first)) / 2
    assert even - constant == pytest.approx(0.0237, rel=0, abs=5e-5)
    assert REPORT_ARM.kinetic_energy(along, third) == pytest.approx(0.02378, rel=0, abs=5e-6)


def test_erratum_parallel_axis_term_of_link_3_counts_once() -> None:
    mass, length, radius = NOMINAL.link_mass[2], 0.24, 0.02
    about_joint = mass * (length**2 / 3 + radius**2 / 4)
    assert ARM.inertia_matrix(np.zeros(3))[2, 2] == pytest.approx(about_joint, rel=0, abs=ROUNDING)


def test_erratum_coriolis_matrix_has_the_signs_and_terms_of_its_symbols() -> None:
    q, velocity, _, _ = random_states(7, 50)
    C = ARM.coriolis_matrix(q, velocity)
    still_slide = ARM.coriolis_matrix(q, velocity * [1.0, 0.0, 1.0])
    np.testing.assert_array_equal(C[:, 0, 1], still_slide[:, 0, 1])
    np.testing.assert_array_equal(C[:, 1, 0], -C[:, 0, 1])
    coupling = NOMINAL.link_mass[2] * 0.12 * np.cos(q[:, 2]) * velocity[:, 2]
    np.testing.assert_allclose(C[:, 1, 2], -coupling, rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(C[:, 2, 0], 0.40 * coupling - C[:, 0, 2], rtol=0, atol=ROUNDING)
    assert (np.abs(C[:, [0, 1, 2], [1, 2, 0]]) > 0).all()


def test_erratum_check_matrices_of_the_report() -> None:
    B = ARM.inertia_matrix(CHECK)
    found = (B[0, 0], B[0, 1], B[0, 2], B[1, 1], B[1, 2], B[2, 2])
    expected = (0.33499, -0.6196, 0.03208, 1.549, -0.0802, 0.01577)
    # half of the last printed digit each; the configuration is known to 1e-4, which moves b_11 by 1e-5
    tolerance = np.array([1.5e-5, 5.1e-5, 1e-5, 5.1e-4, 5.1e-5, 5.1e-6])
    assert (np.abs(np.subtract(found, expected)) < tolerance).all()
    force = ARM.coriolis_matrix(CHECK, CHECK_SPEED) @ np.array(CHECK_SPEED)
    # 1e-4 m of q_2 times ∂²b_11/∂q_2² = 3.1 and two speeds of 0.1 moves the forces by 3.1e-6
    np.testing.assert_allclose(force, (-0.0010466, -0.0010735, 0.0001274), rtol=0, atol=3.2e-6)


def test_erratum_gravity_pulls_joint_3_down() -> None:
    gravity = ARM.gravity_vector(CHECK)
    # printed with the other sign; 1e-4 rad moves it by 8e-5
    assert gravity[2] == pytest.approx(0.5539, rel=0, abs=1.3e-4)
    np.testing.assert_array_equal(gravity[:2], np.zeros(2))
    assert ARM.forward_dynamics(np.zeros(3), np.zeros(3), np.zeros(3))[2] < 0


def test_erratum_potential_energy_is_mass_times_height() -> None:
    q = random_states(8, 20)[0]
    heights = 0.15 * sum(NOMINAL.link_mass) + NOMINAL.link_mass[2] * 0.12 * np.sin(q[:, 2])
    np.testing.assert_allclose(ARM.potential_energy(q), 9.81 * heights, rtol=0, atol=ROUNDING)


def swing(arm: PRPArm, q: Array, velocity: Array) -> tuple[Array, Array]:
    """One second (2001, ..., 3) of an arm that nothing drives, by the classical Runge-Kutta method."""

    def slope(state: Array) -> Array:
        return np.stack([state[1], arm.forward_dynamics(state[0], state[1], np.zeros(3))])

    state = np.stack([q, velocity])
    states = [state]
    for _ in range(2000):
        k_1 = slope(state)
        k_2 = slope(state + TIME_STEP / 2 * k_1)
        k_3 = slope(state + TIME_STEP / 2 * k_2)
        k_4 = slope(state + TIME_STEP * k_3)
        state = state + TIME_STEP / 6 * (k_1 + 2 * k_2 + 2 * k_3 + k_4)
        states.append(state)
    positions, velocities = np.stack(states, axis=1)
    return positions, velocities


def test_free_swing_keeps_its_energy_and_its_momentum_about_joint_1() -> None:
    q, velocity, _, _ = random_states(9, 6)
    positions, velocities = swing(ARM, q, velocity)
    kinetic = ARM.kinetic_energy(positions, velocities)
    assert (np.ptp(kinetic, axis=0) > 0.5).all()  # [J]; the two energies do change into each other
    energy = kinetic + ARM.potential_energy(positions)
    momentum = (ARM.inertia_matrix(positions)[..., 0, :] * velocities).sum(axis=-1)
    # the integrator's error: its fourth order makes it 16 times less per halved step, here 2e-10
    np.testing.assert_allclose(energy - energy[0], np.zeros((2001, 6)), rtol=0, atol=2e-9)
    np.testing.assert_allclose(momentum - momentum[0], np.zeros((2001, 6)), rtol=0, atol=2e-9)


def test_swing_with_viscous_friction_loses_what_the_friction_takes() -> None:
    arm = PRPArm(dataclasses.replace(NOMINAL, viscous_friction=(0.5, 2.0, 0.1)))
    q, velocity, _, _ = random_states(10, 6)
    positions, velocities = swing(arm, q, velocity)
    energy = arm.kinetic_energy(positions, velocities) + arm.potential_energy(positions)
    power = (arm.friction_force(velocities) * velocities).sum(axis=-1)
    lost = np.trapezoid(power, dx=TIME_STEP, axis=0)
    assert (lost > 1.0).all()  # [J]
    # the trapezoidal rule errs by the squared step, a twelfth of it times slopes of 100 W/s: 2e-6
    np.testing.assert_allclose(energy[0] - energy[-1], lost, rtol=0, atol=1e-5)


def test_power_of_torques_contact_and_friction_is_the_rate_of_energy() -> None:
    arm = PRPArm(FRICTION)
    q, velocity, torque, force = random_states(11, 50)
    acceleration = arm.forward_dynamics(q, velocity, torque, force)
    tip_velocity = (arm.geometric_jacobian(q)[:, :3] @ velocity[..., None])[..., 0]
    power = ((torque - arm.friction_force(velocity)) * velocity).sum(axis=-1) - (force * tip_velocity).sum(
        axis=-1
    )

    def energy(time: float) -> Array:
        position = q + time * velocity + time**2 / 2 * acceleration
        speed = velocity + time * acceleration
        total: Array = arm.kinetic_energy(position, speed) + arm.potential_energy(position)
        return total

    step = 1e-6
    rate = (energy(step) - energy(-step)) / (2 * step)
    # truncation: accelerations up to 700 enter it squared, the step squared takes 1e-12 off
    np.testing.assert_allclose(rate, power, rtol=0, atol=1e-6)


@PROPERTY
@given(speeds=SPEEDS)
def test_friction_opposes_motion_and_takes_power(speeds: tuple[float, float, float]) -> None:
    arm, velocity = PRPArm(FRICTION), np.array(speeds)
    force = arm.friction_force(velocity)
    np.testing.assert_array_equal(arm.friction_force(-velocity), -force)
    np.testing.assert_array_equal(np.sign(force), np.sign(velocity))
    viscous, coulomb = np.array(FRICTION.viscous_friction), np.array(FRICTION.coulomb_friction)
    expected = viscous * velocity**2 + coulomb * np.abs(velocity)
    np.testing.assert_allclose(force * velocity, expected, rtol=0, atol=ROUNDING)


def test_bias_force_is_coriolis_friction_and_gravity() -> None:
    arm = PRPArm(FRICTION)
    q, velocity, _, _ = random_states(12, 50)
    coriolis = per_row(PINOCCHIO.coriolis_force, q, velocity)
    expected = coriolis + per_row(PINOCCHIO.gravity_vector, q) + arm.friction_force(velocity)
    np.testing.assert_allclose(arm.bias_force(q, velocity), expected, rtol=0, atol=ROUNDING)
