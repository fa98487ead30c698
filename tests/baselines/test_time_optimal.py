"""Time-optimal regulation: closed-form times of a double integrator, actuator limits, and error dynamics."""

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from prp_gym.baselines import TimeOptimalController, TimeOptimalSettings
from prp_gym.robot import NOMINAL, LinkParameters, PRPArm, RobotParameters
from tests.support.control_interface import INTERFACE, LIMIT, LINK_INTERFACE, PERIOD
from tests.support.controller_simulation import hold, simulate
from tests.support.pinocchio_model import PinocchioArm, per_row, random_arm, random_states

Array = NDArray[np.float64]

INERTIA, TORQUE = 0.5, 30.0  # of the link; its actuator alone accelerates it by 60 rad/s²
WEIGHTLESS = LinkParameters(inertia=INERTIA, viscous_friction=0.0, gravity_moment=0.0)
ARM = {
    "acceleration_share": 0.5,
    "braking_share": 0.6,
    "position_gain": 60.0,
    "velocity_gain": 150.0,
    "speed_limit": [12.0, 2.0, 25.0],
}
GOALS = np.random.default_rng(3).uniform([-2.9, -0.28, -2.9], [2.9, -0.02, 2.9], (8, 3))
STARTS = np.random.default_rng(4).uniform([-2.9, -0.28, -2.9], [2.9, -0.02, 2.9], (8, 3))


def link(**settings: Any) -> TimeOptimalController:
    chosen = {
        "acceleration_share": 0.5,
        "braking_share": 0.8,
        "position_gain": 50.0,
        "velocity_gain": 200.0,
        "speed_limit": 100.0,
    }
    return TimeOptimalController(
        LINK_INTERFACE, TimeOptimalSettings(model=WEIGHTLESS, **{**chosen, **settings})
    )


def arm(**settings: Any) -> TimeOptimalController:
    return TimeOptimalController(INTERFACE, TimeOptimalSettings(**{**ARM, **settings}))


def swing(controller: TimeOptimalController, angle: float, duration: float) -> Array:
    """Error of the weightless link at each period from rest, its motion integrated exactly."""
    q, velocity, state, errors = 0.0, 0.0, None, []
    for _ in range(round(duration / PERIOD)):
        errors.append(angle - q)
        action, state = controller.predict(np.array([q, velocity, angle, 0.0, 0.0]), state)
        acceleration = float(action[0]) * TORQUE / INERTIA
        q += PERIOD * velocity + 0.5 * PERIOD**2 * acceleration
        velocity += PERIOD * acceleration
    return np.array(errors)


def least_time(
    distance: float, acceleration: float, braking: float, speed_limit: float, gain: float
) -> float:
    """From rest to the zone in which the speed is λ times the error, by the areas under the speed."""
    zone, last = braking / gain**2, braking / gain
    top = math.sqrt(
        2.0 * (distance - zone + last**2 / (2.0 * braking)) / (1.0 / acceleration + 1.0 / braking)
    )
    top = min(top, speed_limit)
    ramps = top**2 / (2.0 * acceleration) + (top**2 - last**2) / (2.0 * braking)
    return top / acceleration + (top - last) / braking + (distance - zone - ramps) / top


@pytest.mark.parametrize("distance", [0.3, 1.0, 3.0])
@pytest.mark.parametrize("speed_limit", [4.0, 100.0])
def test_link_arrives_in_the_least_time_of_a_double_integrator(distance: float, speed_limit: float) -> None:
    errors = swing(link(speed_limit=speed_limit), distance, 2.0)
    expected = least_time(distance, 30.0, 24.0, speed_limit, 50.0)
    arrived = PERIOD * int(np.argmax(errors <= 24.0 / 50.0**2))
    # the lag 1/K_V = 5 ms behind the profile where it turns, once each way, and a control period
    assert expected - PERIOD <= arrived <= expected + 2.0 / 200.0 + PERIOD
    assert errors.min() > -1e-3 * distance  # no overshoot
    assert abs(errors[-1]) < 1e-6


def test_without_margin_and_zone_the_time_is_that_of_bang_bang_control() -> None:
    controller = link(acceleration_share=1.0, braking_share=0.95, position_gain=200.0, velocity_gain=400.0)
    errors = swing(controller, 2.0, 1.0)
    least = 2.0 * math.sqrt(2.0 / 60.0)
    arrived = PERIOD * int(np.argmax(np.abs(errors) < 0.01))
    # above the bound by the margin (1.3 %) and the lag of 1/K_V and 1/λ; 0.01 rad earlier saves 4 %
    assert 0.95 * least < arrived < 1.05 * least


def test_profile_is_continuous_with_its_slope_and_brakes_within_its_limit() -> None:
    controller = arm()
    error = np.linspace(-3.0, 3.0, 60001)[:, None] * np.ones(3)
    limit = np.broadcast_to([90.0, 30.0, 300.0], error.shape)
    speed, slope = controller._profile(error, limit)
    spacing = 1e-4
    assert (np.sign(speed) == np.sign(error)).all()
    assert np.abs(np.diff(speed, axis=0)).max() <= 60.0 * spacing * (1.0 + 1e-9)
    assert (speed * slope <= 0.6 * limit * (1.0 + 1e-12))[error[:, 0] > 0.0].all()
    under = np.abs(speed) < np.array(ARM["speed_limit"])
    below = under[:-2] & under[2:]
    differences = (speed[2:] - speed[:-2]) / (2.0 * spacing)
    # beyond the zone the slope falls by up to λ³/b = 12000 per unit: 0.3 over half of a central difference
    np.testing.assert_allclose(slope[1:-1][below], differences[below], atol=0.35)
    assert (slope[np.abs(speed) == np.array(ARM["speed_limit"])] == 0.0).all()


def test_all_torques_stay_within_the_actuator_limits_and_keep_the_direction() -> None:
    oracle = PinocchioArm()
    q, velocity, _, _ = random_states(5, 200)
    velocity *= 0.3  # compensated forces below the limits
    goal, still = np.flip(q, axis=0), np.zeros_like(q)
    given = {
        "joint_position": q,
        "joint_velocity": velocity,
        "desired_joint_position": goal,
        "desired_joint_velocity": still,
        "desired_joint_acceleration": still,
    }
    controller = arm(acceleration_share=1.5)
    torque, _ = controller.control(given, controller.initial_state(given))
    bias = per_row(oracle.inverse_dynamics, q, velocity, still, still)
    compensable = (np.abs(bias) < 0.95 * LIMIT).all(axis=1)
    assert compensable.mean() > 0.5
    assert (np.abs(torque[compensable]) <= LIMIT * (1.0 + 1e-9)).all()
    reached = per_row(oracle.forward_dynamics, q, velocity, torque, still)
    limit = 1.5 * LIMIT / np.array([np.diag(oracle.inertia_matrix(row)) for row in q])
    far = (np.abs(goal - q) > 0.5).all(axis=1) & (np.abs(velocity) < 1.0).all(axis=1) & compensable
    share = reached[far] / (np.sign(goal - q) * limit)[far]
    # every joint accelerates towards its goal with the same share of its own limit
    np.testing.assert_allclose(share, share[:, :1] * np.ones(3), rtol=1e-6, atol=1e-6)
    assert ((share > 0.0) & (share <= 1.0 + 1e-6)).all()


def test_arm_reaches_every_goal_without_overshoot() -> None:
    run = simulate(arm(), STARTS, hold(GOALS), 1.5)
    first = run.joint_error[0]
    beyond = -(run.joint_error * np.sign(first)).min(axis=0)
    # torques held for 2 ms at up to 100 rad/s² and 17 rad/s couple the joints a little: 1 % of the step,
    # and a fifth of the reward's scale for joints that hardly move
    assert (beyond <= 0.01 * np.abs(first) + np.array([0.02, 0.004, 0.02])).all()
    np.testing.assert_allclose(run.joint_error[-1], 0.0, atol=1e-6)
    assert (np.abs(run.torque) <= LIMIT).all()


def test_small_errors_decay_with_the_poles_of_the_gains() -> None:
    start = np.array([0.3, -0.15, 0.4])
    run = simulate(arm(), start, hold(start + 1e-4), 0.2)
    time = PERIOD * np.arange(len(run.joint_error))
    expected = (150.0 * np.exp(-60.0 * time) - 60.0 * np.exp(-150.0 * time)) / 90.0
    # held for 2 ms and stepped by 1 ms: a delay of 1.5 ms in a motion of up to 60/s
    np.testing.assert_allclose(run.joint_error[:, 0] / 1e-4, expected[:, None] * np.ones(3), atol=0.09)


@pytest.mark.parametrize(("integral_gain", "remains"), [(0.0, True), (3000.0, False)])
def test_only_the_integral_removes_what_link_mass_errors_leave(integral_gain: float, remains: bool) -> None:
    heavy = NOMINAL.with_masses((1.5, 1.0, 1.1))
    goal = (0.5, -0.2, 0.3)
    run = simulate(arm(integral_gain=integral_gain), (0.0, -0.1, 0.0), hold(goal), 2.0, plants=[heavy])
    # the third link's weight is compensated for three quarters only: 0.3 N m over K_P B = 142 N m/rad
    assert (abs(run.joint_error[-1, 0, 2]) > 1e-3) == remains
    if not remains:
        np.testing.assert_allclose(run.joint_error[-1], 0.0, atol=1e-6)


def test_integral_is_held_while_a_limit_is_active() -> None:
    controller = link(integral_gain=1000.0)
    far, near = np.array([0.0, 0.0, 1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1e-3, 0.0, 0.0])
    _, held = controller.predict(far)
    _, moved = controller.predict(near)
    assert held is not None
    assert moved is not None
    assert held[0] == 0.0
    assert moved[0] == pytest.approx(PERIOD * 1000.0 * 50.0 * 1e-3)


@pytest.mark.parametrize(
    ("model", "oracle"), [(PRPArm().parameters, PinocchioArm()), random_arm(9)], ids=["nominal", "another"]
)
def test_acceleration_limit_is_the_share_of_what_the_actuator_alone_gives(
    model: RobotParameters, oracle: PinocchioArm
) -> None:
    q = np.array([0.0, -0.1, 0.2])
    expected = 0.5 * LIMIT / np.diag(oracle.inertia_matrix(q))
    limit = arm(model=model)._acceleration_limit(PRPArm(model).inertia_matrix(q))
    np.testing.assert_allclose(limit, expected, rtol=1e-12)
