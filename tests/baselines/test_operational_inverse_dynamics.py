"""Operational-space inverse dynamics: torques against Pinocchio, error dynamics, and contact."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from prp_gym.baselines import (
    ControlInterface,
    OperationalInverseDynamicsController,
    OperationalInverseDynamicsSettings,
)
from prp_gym.errors import MissingFieldError, UnknownNameError
from prp_gym.robot import NOMINAL, PRPArm, RobotParameters
from prp_gym.tasks.fields import MEASURED_FIELDS, POSE_REFERENCE_FIELDS, ObservationLayout
from tests.support.control_interface import (
    LIMIT,
    POSE_INTERFACE,
    POSE_LAYOUT,
    Observed,
    column_space_of,
    oracle_drift,
    oracle_jacobian,
    pose_acceleration,
    random_pose_observation,
)
from tests.support.controller_simulation import Wall, hold, quintic, simulate
from tests.support.pinocchio_model import PinocchioArm, random_arm

Array = NDArray[np.float64]

K_P, K_D = np.array([50.0, 60.0, 70.0, 40.0, 30.0, 20.0]), np.array([10.0, 11.0, 12.0, 14.0, 13.0, 12.0])
DIFFERENCES = 1e-6  # the oracle's J̇_A q̇ is off by 1e-9, torques reach 1e3
MODELS = {"nominal": (NOMINAL, PinocchioArm()), "another": random_arm(12)}


def controller(**settings: Any) -> OperationalInverseDynamicsController:
    chosen = {"proportional_gain": K_P, "derivative_gain": K_D, **settings}
    return OperationalInverseDynamicsController(POSE_INTERFACE, OperationalInverseDynamicsSettings(**chosen))


def wanted(given: Observed) -> Array:
    """ẍ_d + K_D x̃˙ + K_P x̃."""
    acceleration: Array = (
        given["desired_acceleration"]
        + K_D * (given["desired_velocity"] - given["end_effector_velocity"])
        + K_P * (given["desired_pose"] - given["end_effector_pose"])
    )
    return acceleration


@pytest.mark.parametrize("damping", [0.0, 0.3])
@pytest.mark.parametrize(("model", "oracle"), MODELS.values(), ids=MODELS)
def test_torque_is_the_inverse_dynamics_of_the_resolved_acceleration(
    model: RobotParameters, oracle: PinocchioArm, damping: float
) -> None:
    given = random_pose_observation(oracle, 1, 40)
    torque = controller(model=model, pseudoinverse_damping=damping).control(given, ())[0]
    for row, a in enumerate(wanted(given)):
        q, velocity = given["joint_position"][row], given["joint_velocity"][row]
        # a damped pseudoinverse is the plain one of the matrix with λI below it
        tall = np.vstack([oracle_jacobian(oracle, q), damping * np.eye(3)])
        y = np.linalg.pinv(tall) @ np.concatenate([a - oracle_drift(oracle, q, velocity), np.zeros(3)])
        expected = oracle.inverse_dynamics(q, velocity, y, np.zeros(3))
        np.testing.assert_allclose(torque[row], expected, rtol=DIFFERENCES, atol=DIFFERENCES)


def test_what_the_joints_can_do_of_the_wanted_acceleration_is_done() -> None:
    oracle = PinocchioArm()
    given = random_pose_observation(oracle, 2, 40)
    reached = pose_acceleration(oracle, given, controller().control(given, ())[0], np.zeros((40, 3)))
    left = column_space_of(oracle, given, wanted(given) - reached)
    np.testing.assert_allclose(left, 0.0, atol=DIFFERENCES)


def test_compensated_contact_changes_nothing_and_ignored_contact_does() -> None:
    oracle = PinocchioArm()
    given = random_pose_observation(oracle, 3, 40)
    left = {}
    for contact in ("compensated", "ignored"):
        torque = controller(contact=contact).control(given, ())[0]
        reached = pose_acceleration(oracle, given, torque, given["contact_force"])
        left[contact] = np.abs(column_space_of(oracle, given, wanted(given) - reached)).max(axis=1)
    np.testing.assert_allclose(left["compensated"], 0.0, atol=DIFFERENCES)
    assert (left["ignored"] > 0.1).all()


def test_error_along_the_slide_decays_as_a_second_order_system() -> None:
    start = np.array([0.0, -0.1, 0.0])
    run = simulate(
        controller(proportional_gain=100.0, derivative_gain=15.0), start, hold((0.0, -0.2, 0.0)), 1.5
    )
    time = 0.002 * np.arange(len(run.pose))
    damped = np.sqrt(100.0 - 7.5**2)
    expected = 0.1 * np.exp(-7.5 * time) * (np.cos(damped * time) + 7.5 / damped * np.sin(damped * time))
    # held for 2 ms and stepped by 1 ms: a delay of 1.5 ms at speeds up to 0.5 m/s
    np.testing.assert_allclose(run.pose_error[:, 0, 1], expected, atol=1e-3)
    np.testing.assert_allclose(np.delete(run.pose_error[:, 0], 1, axis=1), 0.0, atol=1e-6)


def test_small_error_decays_alike_on_every_axis_from_any_pose() -> None:
    generator = np.random.default_rng(5)
    goal = generator.uniform([-2.9, -0.28, -2.9], [2.9, -0.02, 2.9], (8, 3))
    start = goal + 1e-3 * generator.uniform(-1.0, 1.0, (8, 3))
    run = simulate(controller(proportional_gain=100.0, derivative_gain=15.0), start, hold(goal), 0.6)
    time = 0.002 * np.arange(len(run.pose))
    damped = np.sqrt(100.0 - 7.5**2)
    decay = np.exp(-7.5 * time) * (np.cos(damped * time) + 7.5 / damped * np.sin(damped * time))
    expected = decay[:, None, None] * run.pose_error[0]
    # 1 % of the first error of 1e-3: a delay of 1.5 ms in a motion of up to 5/s
    np.testing.assert_allclose(run.pose_error, expected, atol=2e-5)


def test_reference_through_both_singular_poses_is_followed() -> None:
    start, goal = (-0.5, -0.05, 1.0), (0.8, -0.15, 2.9)
    run = simulate(
        controller(proportional_gain=400.0, derivative_gain=40.0), start, quintic(start, goal, 1.5), 2.0
    )
    q = run.joint_position[:, 0]
    reach = q[:, 1] + 0.3 + 0.24 * np.cos(q[:, 2])
    assert q[:, 2].min() < np.pi / 2 < q[:, 2].max()
    assert reach.min() < 0.0 < reach.max()
    # torques held for 2 ms at up to 10 rad/s²
    np.testing.assert_allclose(run.joint_error, 0.0, atol=2e-3)


def test_only_force_compensation_keeps_the_reference_against_a_wall() -> None:
    depth, wall = 0.01, Wall(100.0, offset=-0.35)
    goal = (0.0, -0.2, 0.0)  # y = -0.34
    gains = {"proportional_gain": 100.0, "derivative_gain": 20.0}
    compensated = simulate(controller(contact="compensated", **gains), goal, hold(goal), 2.5, wall=wall)
    ignored = simulate(controller(contact="ignored", **gains), goal, hold(goal), 2.5, wall=wall)
    np.testing.assert_allclose(compensated.pose_error[-1, 0], 0.0, atol=1e-6)
    assert compensated.force[-1, 0, 1] == pytest.approx(100.0 * depth, rel=1e-4)
    assert ignored.pose_error[-1, 0, 1] > 0.1 * depth


def test_contact_that_is_not_measured_cannot_be_compensated() -> None:
    layout = ObservationLayout((*MEASURED_FIELDS, *POSE_REFERENCE_FIELDS))
    free = ControlInterface("PRP-PoseTracking-v0", layout, LIMIT, 0.002, PRPArm())
    OperationalInverseDynamicsController(free, OperationalInverseDynamicsSettings(K_P, K_D))
    with pytest.raises(MissingFieldError) as caught:
        OperationalInverseDynamicsController(
            free, OperationalInverseDynamicsSettings(K_P, K_D, contact="compensated")
        )
    assert caught.value.missing == ("contact_force",)
    assert "contact_force" in POSE_LAYOUT.names


def test_unknown_contact_mode_lists_the_valid_ones() -> None:
    with pytest.raises(UnknownNameError, match="Valid: compensated, ignored"):
        controller(contact="compensate")
