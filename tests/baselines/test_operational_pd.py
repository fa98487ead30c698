"""Operational-space PD: torques against the formula, dissipated energy, and steady-state error."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from prp_gym.baselines import OperationalPDController, OperationalPDSettings
from prp_gym.robot import NOMINAL, RobotParameters
from tests.support.control_interface import (
    INTERFACE,
    POSE_INTERFACE,
    column_space_of,
    oracle_jacobian,
    oracle_pose,
    random_pose_observation,
)
from tests.support.controller_simulation import hold, simulate
from tests.support.pinocchio_model import PinocchioArm, per_row, random_arm

Array = NDArray[np.float64]

K_P, K_D = np.array([50.0, 60.0, 70.0, 40.0, 30.0, 20.0]), np.array([10.0, 11.0, 12.0, 4.0, 3.0, 2.0])
ROUNDING = 1e-11  # torques up to 1e3, a few dozen operations of 1e-16 each
MODELS = {"nominal": (NOMINAL, PinocchioArm()), "another": random_arm(11)}


def controller(**settings: Any) -> OperationalPDController:
    chosen = {"proportional_gain": K_P, "derivative_gain": K_D, **settings}
    return OperationalPDController(POSE_INTERFACE, OperationalPDSettings(**chosen))


@pytest.mark.parametrize(("model", "oracle"), MODELS.values(), ids=MODELS)
def test_torque_is_gravity_and_springs_and_dampers_at_the_tip(
    model: RobotParameters, oracle: PinocchioArm
) -> None:
    given = random_pose_observation(oracle, 1, 50)
    spring = K_P * (given["desired_pose"] - given["end_effector_pose"])
    damper = K_D * (given["desired_velocity"] - given["end_effector_velocity"])
    expected = per_row(oracle.gravity_vector, given["joint_position"])
    expected = expected + column_space_of(oracle, given, spring + damper)
    torque = controller(model=model).torque(given)
    np.testing.assert_allclose(torque, expected, rtol=ROUNDING, atol=ROUNDING)


def test_constant_reference_gives_the_controller_of_the_report() -> None:
    oracle = PinocchioArm()
    given = random_pose_observation(oracle, 2, 20)
    given["desired_velocity"] = np.zeros((20, 6))
    torque = controller().torque(given)
    for row in range(20):
        q, velocity = given["joint_position"][row], given["joint_velocity"][row]
        J_A = oracle_jacobian(oracle, q)
        error = given["desired_pose"][row] - oracle_pose(oracle, q)
        expected = oracle.gravity_vector(q) + J_A.T @ (K_P * error - K_D * (J_A @ velocity))
        np.testing.assert_allclose(torque[row], expected, rtol=ROUNDING, atol=ROUNDING)


def test_only_the_dampers_take_energy_out() -> None:
    """d/dt (½ q̇ᵀBq̇ + ½ x̃ᵀK_P x̃) = -ẋᵀK_D ẋ for a constant reference."""
    arm, h = PinocchioArm(), 1e-6
    given = random_pose_observation(arm, 3, 20) | {"desired_velocity": np.zeros((20, 6))}
    q, velocity, goal = given["joint_position"], given["joint_velocity"], given["desired_pose"]
    acceleration = per_row(arm.forward_dynamics, q, velocity, controller().torque(given), np.zeros_like(q))

    def stored(step: float) -> Array:
        later = q + step * velocity + step**2 / 2 * acceleration
        poses = np.array([oracle_pose(arm, row) for row in later])
        kinetic = per_row(arm.kinetic_energy, later, velocity + step * acceleration)
        springs: Array = 0.5 * np.sum(K_P * (goal - poses) ** 2, axis=1)
        return kinetic + springs

    rate = (stored(h) - stored(-h)) / (2 * h)
    expected = -np.sum(K_D * given["end_effector_velocity"] ** 2, axis=1)
    # central differences over 1e-6 s: 1e-13 of rounding in energies up to 1e3 J, accelerations up to 1e4
    np.testing.assert_allclose(rate, expected, rtol=1e-5, atol=1e-3)


def test_constant_reference_is_reached_without_steady_error() -> None:
    generator = np.random.default_rng(4)
    start, goal = generator.uniform([-1.0, -0.28, -1.2], [1.0, -0.02, 1.2], (2, 6, 3))
    run = simulate(
        controller(proportional_gain=200.0, derivative_gain=[30.0] * 3 + [6.0, 0.6, 1.0]),
        start,
        hold(goal),
        8.0,
    )
    # after 8 s of a loop whose slowest mode decays with about 3/s
    np.testing.assert_allclose(run.pose_error[-1], 0.0, atol=1e-6)


def test_reference_may_come_from_joint_space() -> None:
    settings = OperationalPDSettings(K_P, K_D)
    goal = hold((0.5, -0.2, 1.0))
    there = simulate(OperationalPDController(POSE_INTERFACE, settings), np.zeros(3), goal, 0.2)
    here = simulate(OperationalPDController(INTERFACE, settings), np.zeros(3), goal, 0.2)
    np.testing.assert_allclose(here.joint_position, there.joint_position, atol=1e-9)  # float32 actions
