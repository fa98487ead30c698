"""Operational inverse dynamics that respects joint limits: which joints it leaves out, row by row."""

from itertools import product
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from prp_gym.baselines import OperationalInverseDynamicsController, OperationalInverseDynamicsSettings
from prp_gym.robot import NOMINAL
from tests.support.control_interface import (
    POSE_INTERFACE,
    Observed,
    oracle_drift,
    oracle_jacobian,
    oracle_pose,
    random_pose_observation,
)
from tests.support.pinocchio_model import PinocchioArm

Array = NDArray[np.float64]

LOWER, UPPER = np.array(NOMINAL.joint_lower), np.array(NOMINAL.joint_upper)
MARGIN = 0.01
ARM = PinocchioArm()
K_P, K_D = np.array([50.0, 60.0, 70.0, 40.0, 30.0, 20.0]), np.array([10.0, 11.0, 12.0, 14.0, 13.0, 12.0])


def controller(joint_limits: str = "respected", **settings: Any) -> OperationalInverseDynamicsController:
    given = {"proportional_gain": K_P, "derivative_gain": K_D, "joint_limits": joint_limits, **settings}
    return OperationalInverseDynamicsController(POSE_INTERFACE, OperationalInverseDynamicsSettings(**given))


def at_limits(seed: int, count: int) -> Observed:
    """Random observations of which every joint of every row lies at a limit with some chance."""
    given, draw = random_pose_observation(ARM, seed, count), np.random.default_rng(seed)
    q = np.clip(given["joint_position"], LOWER + 0.05, UPPER - 0.05)
    which = draw.integers(-1, 2, size=q.shape)
    inside = draw.uniform(0.0, 0.9 * MARGIN, size=q.shape)
    which[:5] = draw.choice([-1, 1], size=(5, 3))
    q = np.where(which < 0, LOWER + inside, np.where(which > 0, UPPER - inside, q))
    velocity = given["joint_velocity"]
    given["joint_position"] = q
    given["end_effector_pose"] = np.array([oracle_pose(ARM, row) for row in q])
    rates = [oracle_jacobian(ARM, row) @ speed for row, speed in zip(q, velocity, strict=True)]
    given["end_effector_velocity"] = np.array(rates)
    for row in range(5):  # all joints at a limit, with a demand beyond it
        outward = np.where(q[row] < (LOWER + UPPER) / 2, -1.0, 1.0) * draw.uniform(1.0, 5.0, 3)
        jacobian, wanted = demand(given, row)
        given["desired_acceleration"][row] += jacobian @ outward - wanted
    return given


def demand(given: Observed, row: int) -> tuple[Array, Array]:
    """J_A and the demanded pose acceleration less J̇_A q̇, of one row."""
    q, velocity = given["joint_position"][row], given["joint_velocity"][row]
    wanted = (
        given["desired_acceleration"][row]
        + K_D * (given["desired_velocity"][row] - given["end_effector_velocity"][row])
        + K_P * (given["desired_pose"][row] - given["end_effector_pose"][row])
    )
    return oracle_jacobian(ARM, q), wanted - oracle_drift(ARM, q, velocity)


def resolved(given: Observed, row: int) -> tuple[Array, set[int]]:
    """Joint accelerations, and the joints left out, one joint set after the other by least squares."""
    q = given["joint_position"][row]
    jacobian, wanted = demand(given, row)
    blocked: set[int] = set()
    while True:
        free = [joint for joint in range(3) if joint not in blocked]
        y = np.zeros(3)
        if free:
            y[free] = np.linalg.lstsq(jacobian[:, free], wanted, rcond=None)[0]
        low = {joint for joint in free if q[joint] <= LOWER[joint] + MARGIN and y[joint] < 0.0}
        high = {joint for joint in free if q[joint] >= UPPER[joint] - MARGIN and y[joint] > 0.0}
        if not low | high:
            return y, blocked
        blocked |= low | high


def test_joint_that_would_press_on_its_limit_is_left_out_and_the_others_do_what_they_can() -> None:
    given = at_limits(3, 200)
    torque, counts = controller().control(given, ())[0], set()
    for row in range(200):
        y, blocked = resolved(given, row)
        counts.add(len(blocked))
        q, velocity = given["joint_position"][row], given["joint_velocity"][row]
        expected = ARM.inverse_dynamics(q, velocity, y, np.zeros(3))
        # the oracle's J̇ is a difference quotient: 1e-9 of torques up to 1e4
        np.testing.assert_allclose(torque[row], expected, rtol=1e-6, atol=1e-5)
    assert counts == {0, 1, 2, 3}


def test_limits_change_nothing_where_no_joint_presses() -> None:
    given = at_limits(4, 200)
    free = [not resolved(given, row)[1] for row in range(200)]
    respected, ignored = controller().control(given, ())[0], controller("ignored").control(given, ())[0]
    assert 20 < sum(free) < 180
    np.testing.assert_array_equal((respected == ignored).all(axis=1), free)


@pytest.mark.parametrize("damping", [0.0, 0.3])
def test_torque_of_a_row_does_not_depend_on_its_neighbours(damping: float) -> None:
    policy, given = controller(pseudoinverse_damping=damping), at_limits(5, 60)
    together = policy.control(given, ())[0]
    pressed = [len(resolved(given, row)[1]) for row in range(60)]
    assert set(pressed) == {0, 1, 2, 3}
    for row in range(60):
        alone = policy.control({name: values[row : row + 1] for name, values in given.items()}, ())[0]
        np.testing.assert_array_equal(alone[0], together[row])
    # beside a row without a blocked joint, and beside one in which all joints are blocked
    for row, other in product(range(0, 60, 7), (pressed.index(0), pressed.index(3))):
        two_rows = policy.control({name: values[[other, row]] for name, values in given.items()}, ())[0]
        np.testing.assert_array_equal(two_rows[1], together[row])
