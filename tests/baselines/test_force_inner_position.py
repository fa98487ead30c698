"""Force control with an inner position loop: its formula, its steady forces, its stability, all surfaces."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from prp_gym.baselines import ForceInnerPositionController, ForceInnerPositionSettings
from prp_gym.errors import InvalidValueError, UnknownNameError
from prp_gym.robot import PRPArm
from tests.support.contact_cases import (
    UNLIMITED,
    controller,
    poor_arms,
    random_cases,
    random_observation,
    repeated,
    slide_direction,
    torque_for,
)
from tests.support.contact_plant import WITHOUT_DESIRED_FORCE, Wall, interface, simulate

Array = NDArray[np.float64]

NAME = "force_inner_position"
HOME = np.zeros((1, 3))
UP = np.array([[0.0, 1.0, 0.0]])
PLANE = Wall(np.array([5.0]), -UP, np.array([0.44]), np.zeros(1))  # y = -0.44, K = 5 N/m
M_D = np.array([0.5, 0.6, 0.7, 0.8, 0.9, 1.0])
K_D = np.array([10.0, 20.0, 30.0, 40.0, 50.0, 60.0])
K_P = np.array([100.0, 200.0, 300.0, 400.0, 500.0, 600.0])


def custom(**settings: Any) -> ForceInnerPositionController:
    numbers = {"inertia": M_D, "derivative_gain": K_D, "proportional_gain": K_P, **settings}
    given = ForceInnerPositionSettings(**{"force_gain": 0.02, "integral_gain": 0.3, **numbers})
    return ForceInnerPositionController(interface(), given)


@pytest.mark.parametrize("origin", ["start", "base"])
def test_torque_and_integral_are_those_of_the_formula(origin: str) -> None:
    start, now = random_observation(1, 20), random_observation(11, 20)
    chosen = custom(origin=origin)
    displacement = np.random.default_rng(5).uniform(-0.1, 0.1, size=(20, 3))
    torque, (after, pose) = chosen.control(now, (displacement, *chosen.initial_state(start)[1:]))
    size = np.linalg.norm(now["desired_force"], axis=1)[:, None]
    n = now["desired_force"] / size
    e = size - np.einsum("ij,ij->i", n, now["contact_force"])[:, None]
    target = start["end_effector_pose"].copy()
    if origin == "base":
        target[:, :3] -= n * np.einsum("ij,ij->i", n, target[:, :3])[:, None]
    target[:, :3] += displacement + 0.02 * e * n
    pull = K_P * (target - now["end_effector_pose"]) - K_D * now["end_effector_velocity"]
    # the oracle's J̇ is a difference quotient: 1e-9 of torques up to 1e4
    np.testing.assert_allclose(torque, torque_for(now, pull / M_D), rtol=1e-6, atol=1e-5)
    np.testing.assert_allclose(after, displacement + 0.002 * 0.3 * e * n, atol=1e-14)
    np.testing.assert_array_equal(pose, start["end_effector_pose"])


def test_without_a_desired_force_the_measured_one_is_led_to_zero() -> None:
    given = ForceInnerPositionSettings(
        inertia=M_D, derivative_gain=K_D, proportional_gain=K_P, force_gain=0.0, integral_gain=0.3
    )
    chosen = ForceInnerPositionController(interface(layout=WITHOUT_DESIRED_FORCE), given)
    observed = random_observation(2, 3)
    del observed["desired_force"]
    observed["contact_force"] = np.array([[0.0, 2.0, 0.0], [0.0, 0.0, 0.0], [-3.0, 0.0, 4.0]])
    _, (displacement, _) = chosen.control(observed, chosen.initial_state(observed))
    expected = [[0.0, -2.0, 0.0], [0.0, 0.0, 0.0], [3.0, 0.0, -4.0]]
    np.testing.assert_allclose(displacement, 0.002 * 0.3 * np.array(expected), atol=1e-15)


@pytest.mark.parametrize(
    ("changes", "duration", "expected"),
    [
        # the slow pole, K_I/K_F = 0.5 1/s, leaves 0.03 exp(-0.49 · 6) = 1.6e-3
        pytest.param({}, 6.0, 1.0, id="PI"),
        pytest.param({"integral_gain": 0.0}, 1.5, 5.0 * (10.0 - 0.1) / 51.0, id="P"),
        pytest.param({"integral_gain": 0.0, "origin": "base"}, 1.5, 10.44 / 10.2, id="P, absolute"),
    ],
)
def test_steady_force_of_the_report(changes: dict[str, Any], duration: float, expected: float) -> None:
    recording = simulate(controller(NAME, "report", limit=UNLIMITED, **changes), HOME, PLANE, UP, duration)
    np.testing.assert_allclose(recording.force[-1], expected * UP, atol=2e-3 if not changes else 1e-5)


@pytest.mark.parametrize(("force_gain", "integral_gain"), [(0.0, 0.04), (5e-4, 0.05)])
def test_fixed_gains_are_stable_up_to_routh_s_bound(force_gain: float, integral_gain: float) -> None:
    """K K_I < (K_D/M_d)(1 + K K_F), here K < 500 N/m with and without K_F."""
    inner = {"inertia": 1.0, "derivative_gain": 20.0, "proportional_gain": 400.0}
    bound = 20.0 / (integral_gain - 20.0 * force_gain)
    stiffness = bound * np.array([0.5, 0.85, 1.15, 1.5])
    q = np.tile([0.4, -0.15, 0.7], (4, 1))
    into = slide_direction(q)
    wall = Wall.ahead(PRPArm().forward_kinematics(q)[:, :3], into, -5.0 / stiffness, stiffness)
    gains = {"force_gain": force_gain, "integral_gain": integral_gain, **inner}
    made = controller(NAME, "report", period=0.001, limit=UNLIMITED, **gains)
    recording = simulate(made, q, wall, 5.2 * into, 3.0)  # pressed by 5 N, 5.2 N desired
    error = np.abs(np.einsum("tnk,nk->tn", recording.force, into) - 5.2)
    grown = error[-500:].max(axis=0) / error[500:1000].max(axis=0)
    # near the bound the oscillation at 22 rad/s grows or decays by ±0.7 1/s: a factor 4 in 2 s
    assert (grown[:2] < 0.5).all()
    assert (grown[2:] > 2.0).all()


def test_tuned_settles_on_every_surface_and_overshoots_little() -> None:
    cases = random_cases(1, 200)
    recording = simulate(controller(NAME, "tuned"), cases.joint_position, cases.wall, cases.desired, 4.0)
    force = cases.pressing(recording)
    error = np.abs(force - cases.force) / cases.force
    assert (error[recording.time >= 3.5] < 0.02).all()
    # all surfaces but the softest and deepest, where 0.04 m + 0.08 m take up to 3.5 s, within 2.5 s
    near = cases.force / cases.wall.stiffness < 0.02
    assert (error[recording.time >= 2.5][:, near] < 0.02).all()
    assert (force.max(axis=0) < 1.2 * cases.force).all()
    touching = force > 0.0
    assert not np.any(touching[:-1] & ~touching[1:])  # never lost
    assert np.abs(recording.action).max() < 1.0
    integral = controller(NAME, "tuned").settings.force_integral(0.002, 5000.0)
    estimate = integral.estimator.surface(
        next(part for part in recording.state if part.shape[-1] == 9)
    ).stiffness
    # without noise only the initial guess and the short delay of the force at impact cause an error
    np.testing.assert_allclose(estimate, cases.wall.stiffness, rtol=0.05)


def test_tuned_tolerates_model_errors_sensor_errors_and_a_one_step_actuation_delay() -> None:
    """For both `MASS_FACTORS`, side by side."""
    cases = repeated(random_cases(2, 40), 2)
    world = poor_arms(40, (0.05,))
    made = controller(NAME, "tuned")
    recording = simulate(made, cases.joint_position, cases.wall, cases.desired, 4.0, None, world)
    force = cases.pressing(recording)
    late = force[recording.time >= 3.0]
    # the sensor is tared before the touch, by a mean over noise of 0.05 N
    np.testing.assert_allclose(late.mean(axis=0), cases.force, atol=0.02)
    # and trembles with the noise of 0.05 N that the compensation hands to the torques
    assert late.std(axis=0).max() < 0.05
    # at 30 % too little or too much mass the inner loop brakes later; the rest is noise of 0.05 N
    assert (force.max(axis=0) < 1.15 * cases.force + 0.1).all()
    touching = force > 0.0
    assert np.count_nonzero(touching[:-1] & ~touching[1:], axis=0).max() <= 1


def test_tuned_stands_a_damped_surface() -> None:
    cases = random_cases(3, 20)
    wall = cases.wall
    damping = 0.2 * np.sqrt(wall.stiffness * 1.55)  # a tenth of critical, for the mass of slide and hand
    damped = Wall(wall.stiffness, wall.normal, wall.offset, damping)
    recording = simulate(controller(NAME, "tuned"), cases.joint_position, damped, cases.desired, 3.0)
    error = np.abs(cases.pressing(recording) - cases.force) / cases.force
    near = cases.force / wall.stiffness < 0.02  # as above: the deep ones are still on their way
    assert (error[recording.time >= 2.5][:, near] < 0.02).all()


def test_fixed_gain_that_suits_the_softest_surface_fails_on_the_stiffest() -> None:
    """K_I = 10/50: after 240/10 · 50 N/m Routh forbids it; the estimated form passes the same surfaces."""
    cases = random_cases(1, 4)
    fixed = controller(NAME, "tuned", stiffness="fixed", integral_gain=0.2)
    recording = simulate(fixed, cases.joint_position, cases.wall, cases.desired, 2.5)
    late = np.abs(cases.pressing(recording) - cases.force)[recording.time >= 2.0].max(axis=0)
    assert (late[:2] > 1.0).all()
    assert (late[2:] < 0.05).all()


def test_wrong_settings_are_refused() -> None:
    with pytest.raises(InvalidValueError, match="inertia"):
        custom(inertia=0.0)
    for choice in ("origin", "stiffness"):
        with pytest.raises(UnknownNameError, match=choice):
            custom(**{choice: "guessed"})
    with pytest.raises(InvalidValueError, match="initial_stiffness"):
        custom(stiffness="estimated", initial_stiffness=0.0)
