"""Compliance control: torques against the formula in the desired frame, and contact with a wall."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from prp_gym.baselines import (
    ComplianceController,
    ComplianceSettings,
    OperationalPDController,
    OperationalPDSettings,
)
from prp_gym.robot import NOMINAL, RobotParameters
from tests.support.control_interface import (
    POSE_INTERFACE,
    oracle_jacobian,
    oracle_pose,
    random_pose_observation,
)
from tests.support.controller_simulation import Wall, hold, simulate
from tests.support.pinocchio_model import PinocchioArm, random_arm, random_states

pin: Any = pytest.importorskip("pinocchio")

Array = NDArray[np.float64]

STIFFNESS = np.array([50.0, 160.0, 270.0, 40.0, 30.0, 20.0])
DAMPING = np.array([10.0, 21.0, 32.0, 4.0, 3.0, 2.0])
ROUNDING = 1e-11  # torques up to 1e3, a few dozen operations of 1e-16 each
MODELS = {"nominal": (NOMINAL, PinocchioArm()), "another": random_arm(13)}
HOME, GOAL = np.zeros(3), np.array([0.0, -0.2, 0.0])  # y = -0.54 and -0.34: the goal lies 0.1 m in the wall


def controller(**settings: Any) -> ComplianceController:
    chosen = {"stiffness": STIFFNESS, "damping": DAMPING, **settings}
    return ComplianceController(POSE_INTERFACE, ComplianceSettings(**chosen))


@pytest.mark.parametrize(("model", "oracle"), MODELS.values(), ids=MODELS)
def test_springs_and_dampers_lie_along_the_axes_of_the_desired_frame(
    model: RobotParameters, oracle: PinocchioArm
) -> None:
    given = random_pose_observation(oracle, 1, 40)
    goals, *_ = random_states(2, 40)
    given["desired_pose"] = np.array([oracle_pose(oracle, goal) for goal in goals])
    torque = controller(model=model).torque(given)
    for row in range(40):
        q, velocity = given["joint_position"][row], given["joint_velocity"][row]
        into_desired = np.eye(6)
        into_desired[:3, :3] = oracle.tip_transform(goals[row])[:3, :3].T
        J_Ad = into_desired @ oracle_jacobian(oracle, q)
        error = into_desired @ (given["desired_pose"][row] - oracle_pose(oracle, q))
        force = np.diag(STIFFNESS) @ error - np.diag(DAMPING) @ J_Ad @ velocity
        expected = oracle.gravity_vector(q) + J_Ad.T @ force
        np.testing.assert_allclose(torque[row], expected, rtol=ROUNDING, atol=ROUNDING)


def test_desired_frame_turns_by_all_three_euler_angles() -> None:
    oracle = PinocchioArm()
    given = random_pose_observation(oracle, 3, 20)
    angles = np.random.default_rng(3).uniform(-3.0, 3.0, (20, 3))
    given["desired_pose"] = np.concatenate([given["desired_pose"][:, :3], angles], axis=1)
    torque = controller().torque(given)
    for row in range(20):
        axes = np.linalg.multi_dot(
            [pin.utils.rotate(axis, a) for axis, a in zip("zxz", angles[row], strict=True)]
        )
        turned = [
            np.block([[axes @ np.diag(k[:3]) @ axes.T, np.zeros((3, 3))], [np.zeros((3, 3)), np.diag(k[3:])]])
            for k in (STIFFNESS, DAMPING)
        ]
        error = given["desired_pose"][row] - given["end_effector_pose"][row]
        force = turned[0] @ error - turned[1] @ given["end_effector_velocity"][row]
        q = given["joint_position"][row]
        expected = oracle.gravity_vector(q) + oracle_jacobian(oracle, q).T @ force
        np.testing.assert_allclose(torque[row], expected, rtol=ROUNDING, atol=ROUNDING)


def test_equal_springs_and_dampers_know_no_frame() -> None:
    given = random_pose_observation(PinocchioArm(), 4, 20) | {"desired_velocity": np.zeros((20, 6))}
    gains = [50.0] * 3 + [40.0, 30.0, 20.0], [10.0] * 3 + [4.0, 3.0, 2.0]
    plain = OperationalPDController(POSE_INTERFACE, OperationalPDSettings(*gains)).torque(given)
    compliant = ComplianceController(POSE_INTERFACE, ComplianceSettings(*gains)).torque(given)
    np.testing.assert_allclose(compliant, plain, rtol=ROUNDING, atol=ROUNDING)


def test_contact_force_and_moving_reference_are_not_read() -> None:
    given = random_pose_observation(PinocchioArm(), 5, 20)
    blind = {name: values for name, values in given.items() if name != "contact_force"}
    blind["desired_velocity"] = blind["desired_acceleration"] = np.zeros((20, 6))
    np.testing.assert_array_equal(controller().torque(blind), controller().torque(given))


def test_wall_is_pressed_as_by_two_springs_in_series() -> None:
    stiffness = np.array([1.0, 50.0, 1000.0, 5000.0])
    quiet = controller(stiffness=50.0, damping=[15.0, 15.0, 15.0, 8.0, 1.0, 1.0])
    run = simulate(quiet, [HOME] * 4, hold(GOAL), 4.0, wall=Wall(stiffness))
    expected = 0.1 * stiffness * 50.0 / (stiffness + 50.0)
    # 4 s of a mode that decays with 5/s leave 1e-7 of 0.1 m, times the stiffness
    np.testing.assert_allclose(run.force[-1, :, 1], expected, rtol=2e-4)


def test_wall_feels_the_spring_along_the_desired_frame_s_approach_axis() -> None:
    along_y = np.argmax(np.abs(PinocchioArm().tip_transform(GOAL)[1, :3]))
    soft = np.full(6, 50.0)
    soft[along_y] = 20.0
    quiet = controller(stiffness=soft, damping=[15.0, 15.0, 15.0, 8.0, 1.0, 1.0])
    run = simulate(quiet, HOME, hold(GOAL), 5.0, wall=Wall(100.0))
    assert along_y == 2
    assert run.force[-1, 0, 1] == pytest.approx(0.1 * 100.0 * 20.0 / 120.0, rel=1e-3)  # after 5 s of 2/s
