"""Recursive Newton-Euler inverse dynamics against the closed form, Pinocchio and its own linearity."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from prp_gym.robot import NOMINAL, REPORT, PRPArm, RobotParameters
from prp_gym.robot.newton_euler import recursive_newton_euler
from tests.support.pinocchio_model import Array, PinocchioArm, per_row, random_arm, random_states

PROPERTY = settings(max_examples=50, deadline=None, derandomize=True)
NUMBERS = st.floats(-5.0, 5.0)
TRIPLES = st.tuples(NUMBERS, NUMBERS, NUMBERS)
JOINTS = st.tuples(NUMBERS, st.floats(-0.8, 0.4), NUMBERS)
VISCOUS, COULOMB = (0.5, 2.0, 0.1), (0.3, 1.5, 0.05)
ROUNDING = 1e-12  # forces up to about 100, a hundred operations of 1e-16 each
REPORTS_STATE = ((0.4, -0.2328, 0.9573), (0.1, -0.1, 0.1))


def with_friction(parameters: RobotParameters) -> PRPArm:
    """An arm with friction in all joints."""
    return PRPArm(dataclasses.replace(parameters, viscous_friction=VISCOUS, coulomb_friction=COULOMB))


def friction(velocity: Array) -> Array:
    """The torques that overcome the friction of `with_friction`."""
    force: Array = np.array(VISCOUS) * velocity + np.array(COULOMB) * np.sign(velocity)
    return force


ARMS = [with_friction(NOMINAL), with_friction(REPORT), *(with_friction(random_arm(i)[0]) for i in range(4))]
EVERY_ARM = pytest.mark.parametrize(
    "arm", ARMS, ids=["nominal", "report", "random_0", "random_1", "random_2", "random_3"]
)


@EVERY_ARM
def test_torques_equal_the_closed_form_with_friction_and_contact(arm: PRPArm) -> None:
    q, velocity, acceleration, force = random_states(0, 100)
    linear_jacobian = arm.geometric_jacobian(q)[:, :3]
    closed = (
        (arm.inertia_matrix(q) @ acceleration[..., None])[..., 0]
        + (arm.coriolis_matrix(q, velocity) @ velocity[..., None])[..., 0]
        + arm.gravity_vector(q)
        + friction(velocity)
        + (linear_jacobian.mT @ force[..., None])[..., 0]
    )
    torque = arm.inverse_dynamics(q, velocity, acceleration, force)
    np.testing.assert_allclose(torque, closed, rtol=0, atol=ROUNDING)


def test_torques_equal_pinocchios_with_friction_and_contact() -> None:
    q, velocity, acceleration, force = random_states(1, 100)
    models = [(NOMINAL, PinocchioArm()), *(random_arm(seed) for seed in range(4, 8))]
    for parameters, oracle in models:
        torque = with_friction(parameters).inverse_dynamics(q, velocity, acceleration, force)
        expected = per_row(oracle.inverse_dynamics, q, velocity, acceleration, force) + friction(velocity)
        np.testing.assert_allclose(torque, expected, rtol=0, atol=ROUNDING)


@EVERY_ARM
def test_forward_dynamics_undoes_inverse_dynamics(arm: PRPArm) -> None:
    q, velocity, acceleration, force = random_states(2, 100)
    torque = arm.inverse_dynamics(q, velocity, acceleration, force)
    back = arm.forward_dynamics(q, velocity, torque, force)
    # the inverse of B, up to 110 in norm, multiplies the rounding of the torques
    np.testing.assert_allclose(back, acceleration, rtol=0, atol=110 * ROUNDING)


@EVERY_ARM
def test_inverse_dynamics_undoes_forward_dynamics(arm: PRPArm) -> None:
    q, velocity, torque, force = random_states(3, 100)
    acceleration = arm.forward_dynamics(q, velocity, torque, force)
    back = arm.inverse_dynamics(q, velocity, acceleration, force)
    np.testing.assert_allclose(back, torque, rtol=0, atol=ROUNDING)


def test_sweep_itself_leaves_friction_out() -> None:
    q, velocity, acceleration, force = random_states(4, 20)
    swept = recursive_newton_euler(ARMS[0], q, velocity, acceleration, force)
    expected = ARMS[0].inverse_dynamics(q, velocity, acceleration, force) - friction(velocity)
    np.testing.assert_allclose(swept, expected, rtol=0, atol=ROUNDING)


def test_columns_of_the_inertia_matrix_are_torques_of_unit_accelerations() -> None:
    arm = PRPArm(dataclasses.replace(NOMINAL, gravity=0.0))
    q = random_states(5, 50)[0]
    for joint, acceleration in enumerate(np.eye(3)):
        torque = arm.inverse_dynamics(q, np.zeros(3), acceleration)
        np.testing.assert_allclose(torque, arm.inertia_matrix(q)[..., joint], rtol=0, atol=ROUNDING)


def test_contact_force_is_counted_as_that_of_the_tip_on_the_environment() -> None:
    arm, still = PRPArm(), np.zeros(3)
    home = np.zeros(3)
    pressing = arm.inverse_dynamics(home, still, still, (0.0, 1.0, 0.0)) - arm.gravity_vector(home)
    # at home the slide points along -y and the tip is 0.4 m off joint 1's axis: pushing along +y takes
    # a pull of the slide and a turn of joint 1
    np.testing.assert_allclose(pressing, (0.4, -1.0, 0.0), rtol=0, atol=ROUNDING)
    lifting = arm.inverse_dynamics(home, still, still, (0.0, 0.0, 1.0)) - arm.gravity_vector(home)
    np.testing.assert_allclose(lifting, (0.0, 0.0, 0.24), rtol=0, atol=ROUNDING)


def test_erratum_both_algorithms_agree_where_the_report_found_them_to_differ() -> None:
    for parameters in (NOMINAL, REPORT):
        arm, (q, velocity) = PRPArm(parameters), REPORTS_STATE
        swept = arm.inverse_dynamics(q, velocity, np.zeros(3)) - arm.gravity_vector(q)
        closed = arm.coriolis_matrix(q, velocity) @ np.array(velocity)
        np.testing.assert_allclose(swept, closed, rtol=0, atol=ROUNDING)


def test_erratum_report_preset_gives_the_column_that_the_report_swapped() -> None:
    q, velocity = REPORTS_STATE
    torque = PRPArm(REPORT).inverse_dynamics(q, velocity, np.zeros(3)) - PRPArm(REPORT).gravity_vector(q)
    # the printed column was made with another of the report's tensors, b_33 = 0.04708 for 0.04757: one
    # per cent of the term in S_3 C_3; the configuration, known to 1e-4, moves the forces by 3.1e-6
    np.testing.assert_allclose(torque, (-0.001341, -0.001073, 0.0002748), rtol=0, atol=6e-6)


@PROPERTY
@given(joints=JOINTS, speeds=TRIPLES, first=TRIPLES, second=TRIPLES)
def test_torques_are_affine_in_the_acceleration(
    joints: tuple[float, ...], speeds: tuple[float, ...], first: tuple[float, ...], second: tuple[float, ...]
) -> None:
    arm = ARMS[0]
    both = arm.inverse_dynamics(joints, speeds, np.add(first, second))
    none = arm.inverse_dynamics(joints, speeds, np.zeros(3))
    one, other = arm.inverse_dynamics(joints, speeds, first), arm.inverse_dynamics(joints, speeds, second)
    np.testing.assert_allclose(both + none, one + other, rtol=0, atol=ROUNDING)


@PROPERTY
@given(joints=JOINTS, speeds=TRIPLES, acceleration=TRIPLES)
def test_without_friction_the_motion_run_backwards_takes_the_same_torques(
    joints: tuple[float, ...], speeds: tuple[float, ...], acceleration: tuple[float, ...]
) -> None:
    arm = PRPArm()
    forwards = arm.inverse_dynamics(joints, speeds, acceleration)
    backwards = arm.inverse_dynamics(joints, -np.array(speeds), acceleration)
    np.testing.assert_allclose(forwards, backwards, rtol=0, atol=ROUNDING)


@PROPERTY
@given(joints=JOINTS, speeds=TRIPLES, acceleration=TRIPLES, factor=st.floats(0.1, 10.0))
def test_arm_of_another_density_takes_torques_in_proportion(
    joints: tuple[float, ...], speeds: tuple[float, ...], acceleration: tuple[float, ...], factor: float
) -> None:
    denser = PRPArm(NOMINAL.scaled([factor] * 3)).inverse_dynamics(joints, speeds, acceleration)
    nominal = PRPArm().inverse_dynamics(joints, speeds, acceleration)
    np.testing.assert_allclose(denser, factor * nominal, rtol=0, atol=10 * ROUNDING)
