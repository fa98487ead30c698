"""Joint-space inverse dynamics: torques against Pinocchio, with an exact and an inexact model."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from prp_gym.baselines import JointInverseDynamicsController, JointInverseDynamicsSettings
from prp_gym.robot import NOMINAL, PRPArm, RobotParameters
from tests.support.control_interface import INTERFACE, LINK_INTERFACE
from tests.support.pinocchio_model import PinocchioArm, per_row, random_arm, random_states

Array = NDArray[np.float64]

K_P, K_D = np.array([50.0, 500.0, 100.0]), np.array([10.0, 35.0, 15.0])
ROUNDING = 1e-11  # torques up to 1e4, a few dozen operations of 1e-16 each
MODELS = {"nominal": (NOMINAL, PinocchioArm()), "another": random_arm(9)}


def controller(**settings: Any) -> JointInverseDynamicsController:
    chosen = {"proportional_gain": K_P, "derivative_gain": K_D, **settings}
    return JointInverseDynamicsController(INTERFACE, JointInverseDynamicsSettings(**chosen))


def observed(seed: int, count: int) -> dict[str, Array]:
    """Random measurements and references, (count, 3) each."""
    q, velocity, _, _ = random_states(seed, count)
    desired, desired_velocity, desired_acceleration, _ = random_states(seed + 1, count)
    return {
        "joint_position": q,
        "joint_velocity": velocity,
        "desired_joint_position": desired,
        "desired_joint_velocity": desired_velocity,
        "desired_joint_acceleration": desired_acceleration,
    }


def wanted_acceleration(given: dict[str, Array]) -> Array:
    """y, joint by joint."""
    y = given["desired_joint_acceleration"].copy()
    for joint in range(3):
        y[:, joint] += K_D[joint] * (given["desired_joint_velocity"] - given["joint_velocity"])[:, joint]
        y[:, joint] += K_P[joint] * (given["desired_joint_position"] - given["joint_position"])[:, joint]
    return y


@pytest.mark.parametrize(("model", "oracle"), MODELS.values(), ids=MODELS)
def test_torque_is_the_inverse_dynamics_of_the_wanted_acceleration(
    model: RobotParameters, oracle: PinocchioArm
) -> None:
    given = observed(1, 50)
    q, velocity = given["joint_position"], given["joint_velocity"]
    expected = per_row(oracle.inverse_dynamics, q, velocity, wanted_acceleration(given), np.zeros_like(q))
    torque = controller(model=model).control(given, ())[0]
    np.testing.assert_allclose(torque, expected, rtol=ROUNDING, atol=ROUNDING)


@pytest.mark.parametrize(("model", "oracle"), MODELS.values(), ids=MODELS)
def test_torque_is_inertia_times_acceleration_and_bias(model: RobotParameters, oracle: PinocchioArm) -> None:
    given = observed(2, 50)
    q, velocity, still = given["joint_position"], given["joint_velocity"], np.zeros((50, 3))
    bias = per_row(oracle.inverse_dynamics, q, velocity, still, still)
    inertia = per_row(oracle.inertia_matrix, q)
    expected = np.einsum("nij,nj->ni", inertia, wanted_acceleration(given)) + bias
    torque = controller(model=model).control(given, ())[0]
    np.testing.assert_allclose(torque, expected, rtol=ROUNDING, atol=ROUNDING)


@pytest.mark.parametrize(("model", "oracle"), MODELS.values(), ids=MODELS)
def test_exact_model_gives_every_joint_the_wanted_acceleration(
    model: RobotParameters, oracle: PinocchioArm
) -> None:
    given = observed(3, 50)
    q, velocity = given["joint_position"], given["joint_velocity"]
    torque = controller(model=model).control(given, ())[0]
    acceleration = per_row(oracle.forward_dynamics, q, velocity, torque, np.zeros_like(q))
    # the inertia matrix is inverted: its condition number, up to 1e3, multiplies the rounding
    np.testing.assert_allclose(acceleration, wanted_acceleration(given), rtol=1e-9, atol=1e-9)


def test_link_mass_errors_do_not() -> None:
    given = observed(4, 50)
    q, velocity = given["joint_position"], given["joint_velocity"]
    inaccurate = NOMINAL.with_masses((0.9, 0.5, 0.7))
    torque = controller(model=inaccurate).control(given, ())[0]
    acceleration = per_row(PinocchioArm().forward_dynamics, q, velocity, torque, np.zeros_like(q))
    # every mass is at least 14 % too small
    missing = np.linalg.norm(acceleration - wanted_acceleration(given), axis=1)
    assert (missing > 0.05 * np.linalg.norm(wanted_acceleration(given), axis=1)).all()


def test_friction_of_the_model_is_compensated() -> None:
    given = observed(5, 20)
    viscous, coulomb = (0.5, 2.0, 0.1), (0.3, 1.5, 0.05)
    rough = replace(NOMINAL, viscous_friction=viscous, coulomb_friction=coulomb)
    extra = controller(model=rough).control(given, ())[0] - controller().control(given, ())[0]
    velocity = given["joint_velocity"]
    expected = np.array(viscous) * velocity + np.array(coulomb) * np.sign(velocity)
    np.testing.assert_allclose(extra, expected, rtol=ROUNDING, atol=ROUNDING)


def test_arm_on_its_reference_needs_the_reference_s_own_torques() -> None:
    q, velocity, acceleration, _ = random_states(6, 20)
    on_reference = {
        "joint_position": q,
        "joint_velocity": velocity,
        "desired_joint_position": q,
        "desired_joint_velocity": velocity,
        "desired_joint_acceleration": acceleration,
    }
    expected = per_row(PinocchioArm().inverse_dynamics, q, velocity, acceleration, np.zeros_like(q))
    for gains in (K_P, 0.0, 1e3):
        torque = controller(proportional_gain=gains, derivative_gain=gains).control(on_reference, ())[0]
        np.testing.assert_allclose(torque, expected, rtol=ROUNDING, atol=ROUNDING)


def test_model_is_nominal_unless_named() -> None:
    assert JointInverseDynamicsSettings(K_P, K_D).model is None
    assert controller().model == PRPArm(NOMINAL)


def test_link_is_controlled_by_the_same_controller() -> None:
    pendulum = JointInverseDynamicsController(LINK_INTERFACE, JointInverseDynamicsSettings(7.0, 2.0))
    torque = pendulum.control(pendulum.interface.layout.split([0.3, -0.5, 0.6, 0.7, 1.1]), ())[0]
    y = 1.1 + 2.0 * 1.2 + 7.0 * 0.3
    assert torque == pytest.approx(0.5 * y - 0.15 * 0.5 + 1.85 * np.sin(0.3), rel=1e-13)
