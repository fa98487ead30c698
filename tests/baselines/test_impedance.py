"""Impedance control: torques against Pinocchio, the rendered impedance, and contact with a wall."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from prp_gym.baselines import ImpedanceController, ImpedanceSettings
from prp_gym.errors import InvalidValueError
from prp_gym.robot import NOMINAL, RobotParameters
from tests.support.control_interface import (
    POSE_INTERFACE,
    Observed,
    column_space_of,
    oracle_drift,
    oracle_jacobian,
    pose_acceleration,
    random_pose_observation,
)
from tests.support.controller_simulation import Reference, Wall, hold, quintic, simulate
from tests.support.pinocchio_model import PinocchioArm, random_arm

Array = NDArray[np.float64]

INERTIA = np.array([0.5, 0.7, 0.9, 1.0, 1.2, 1.4])
DAMPING = np.array([10.0, 11.0, 12.0, 4.0, 3.0, 2.0])
STIFFNESS = np.array([50.0, 60.0, 70.0, 40.0, 30.0, 20.0])
DIFFERENCES = 1e-6  # the oracle's J̇_A q̇ is off by 1e-9, torques reach 1e3
MODELS = {"nominal": (NOMINAL, PinocchioArm()), "another": random_arm(14)}
HOME, GOAL = np.zeros(3), np.array([0.0, -0.2, 0.0])  # y = -0.54 and -0.34: the goal lies 0.1 m in the wall


def controller(**settings: Any) -> ImpedanceController:
    chosen = {"inertia": INERTIA, "damping": DAMPING, "stiffness": STIFFNESS, **settings}
    return ImpedanceController(POSE_INTERFACE, ImpedanceSettings(**chosen))


def wanted(given: Observed) -> Array:
    """ẍ_d + M_d⁻¹(K_D x̃˙ + K_P x̃ - h_A)."""
    force = np.zeros_like(given["desired_pose"])
    force[:, :3] = given["contact_force"]
    pull = DAMPING * (given["desired_velocity"] - given["end_effector_velocity"]) - force
    pull = pull + STIFFNESS * (given["desired_pose"] - given["end_effector_pose"])
    acceleration: Array = given["desired_acceleration"] + pull / INERTIA
    return acceleration


@pytest.mark.parametrize(("model", "oracle"), MODELS.values(), ids=MODELS)
def test_torque_is_the_inverse_dynamics_of_the_model_s_acceleration_and_the_force(
    model: RobotParameters, oracle: PinocchioArm
) -> None:
    given = random_pose_observation(oracle, 1, 40)
    torque = controller(model=model).control(given, ())[0]
    for row, a in enumerate(wanted(given)):
        q, velocity = given["joint_position"][row], given["joint_velocity"][row]
        y = np.linalg.pinv(oracle_jacobian(oracle, q)) @ (a - oracle_drift(oracle, q, velocity))
        expected = oracle.inverse_dynamics(q, velocity, y, given["contact_force"][row])
        np.testing.assert_allclose(torque[row], expected, rtol=DIFFERENCES, atol=DIFFERENCES)


def test_tip_in_contact_accelerates_as_the_model_as_far_as_the_joints_can() -> None:
    oracle = PinocchioArm()
    given = random_pose_observation(oracle, 2, 40)
    reached = pose_acceleration(oracle, given, controller().control(given, ())[0], given["contact_force"])
    left = column_space_of(oracle, given, wanted(given) - reached)
    np.testing.assert_allclose(left, 0.0, atol=DIFFERENCES)


def modelled(reference: Reference, wall: Wall, duration: float, numbers: tuple[float, ...]) -> Array:
    """y (T, N) of M ÿ~ + D ẏ~ + K y~ = h, y~ = y_d - y, on each wall; Runge-Kutta, 0.5 ms."""
    mass, damping, stiffness = numbers
    h, conditions = 5e-4, []
    state = np.stack([np.full(np.shape(wall.stiffness), -0.54), np.zeros(np.shape(wall.stiffness))])

    def slope(time: float, at: Array) -> Array:
        position, rate, curve = (-float(part[0, 1]) for part in reference(time))  # y = -0.54 - q_2
        force = wall.stiffness * np.maximum(at[0] - wall.offset, 0.0)
        pull = damping * (rate - at[1]) + stiffness * (position - 0.54 - at[0]) - force
        return np.stack([at[1], curve + pull / mass])

    for step in range(round(duration / h)):
        if step % 4 == 0:
            conditions.append(state[0])
        time = step * h
        a = slope(time, state)
        b = slope(time + h / 2, state + h / 2 * a)
        c = slope(time + h / 2, state + h / 2 * b)
        d = slope(time + h, state + h * c)
        state = state + h / 6 * (a + 2 * b + 2 * c + d)
    return np.array(conditions)


@pytest.mark.parametrize("numbers", [(0.5, 10.0, 50.0), (0.5, 25.0, 75.0), (2.0, 20.0, 30.0)])
def test_tip_moves_into_walls_as_the_mass_damper_and_spring(numbers: tuple[float, ...]) -> None:
    reference, wall = quintic(HOME, GOAL, 1.0), Wall(np.array([0.0, 50.0, 300.0]))
    policy = controller(inertia=numbers[0], damping=numbers[1], stiffness=numbers[2])
    run = simulate(policy, [HOME] * 3, reference, 2.5, wall=wall)
    # a delay of 1.5 ms at up to 0.4 m/s, and at up to 25/s where the wall is hit
    np.testing.assert_allclose(run.pose[..., 1], modelled(reference, wall, 2.5, numbers), atol=1e-3)
    np.testing.assert_allclose(run.pose[..., 0], 0.4, atol=1e-6)
    np.testing.assert_allclose(run.pose[..., 2], 0.15, atol=1e-6)


@pytest.mark.parametrize("spring", [50.0, 75.0])
def test_wall_is_pressed_as_by_two_springs_in_series(spring: float) -> None:
    stiffness = np.array([1.0, 50.0, 1000.0, 5000.0])
    policy = controller(inertia=0.5, damping=10.0, stiffness=spring)
    run = simulate(policy, [HOME] * 4, hold(GOAL), 4.0, wall=Wall(stiffness))
    expected = 0.1 * stiffness * spring / (stiffness + spring)
    # 4 s of a mode that decays with 5/s or more leave less than 1e-7 m, times the stiffness
    np.testing.assert_allclose(run.force[-1, :, 1], expected, rtol=2e-4)


@pytest.mark.parametrize("inertia", [0.0, [1.0, 1.0, 1.0, 0.0, 1.0, 1.0]])
def test_model_without_inertia_is_refused(inertia: Any) -> None:
    with pytest.raises(InvalidValueError, match=r"inertia is .* kg \(3\), kg·m² \(3\); allowed: above 0"):
        controller(inertia=inertia)
