"""Errata of the report in its motion control laws, their set-points and gains."""

import math
from collections.abc import Callable

import numpy as np
import pytest

from prp_gym.errors import ShapeError
from prp_gym.robot import PRPArm
from prp_gym.tasks.trajectory import QuinticWaypoints, Sine
from tests.support.integration import runge_kutta
from tests.support.pinocchio_model import Array, PinocchioArm

ARM, PINOCCHIO = PRPArm(), PinocchioArm()
GOAL = np.array([np.pi / 2, -0.2, np.pi])
K_P, K_D = 50.0, 10.0  # of 6.1 and 7.1
STILL = np.zeros(3)
ROUNDING = 1e-10  # of thousands of steps of 1e-14 each


def closed_loop(torque: Callable[[Array, Array], Array], start: Array, step: float, count: int) -> Array:
    """Positions and velocities (count + 1, 2, ..., 3) of the arm under τ(q, q̇), from rest."""

    def slope(_: float, state: Array) -> Array:
        q, v = state
        return np.stack([v, ARM.forward_dynamics(q, v, torque(q, v))])

    return runge_kutta(slope, np.stack([start, np.zeros(start.shape)]), step, count)


def test_printed_pd_control_is_centred_at_four_fifths_of_the_goal_and_never_comes_to_rest() -> None:
    def printed(q: Array, v: Array) -> Array:
        """q̇_d = 0: the term K_D (q̇_d - q_d) is constant."""
        return ARM.gravity_vector(q) + K_P * (GOAL - q) + K_D * (0.0 - GOAL)

    def right(q: Array, v: Array) -> Array:
        return ARM.gravity_vector(q) + K_P * (GOAL - q) + K_D * (0.0 - v)

    false_goal = (1 - K_D / K_P) * GOAL
    for controller, rest, other in ((printed, false_goal, GOAL), (right, GOAL, false_goal)):
        at_rest = PINOCCHIO.forward_dynamics(rest, STILL, controller(rest, STILL), STILL)
        np.testing.assert_allclose(at_rest, 0.0, rtol=0, atol=1e-12)  # the rounding of torques up to 30
        assert np.abs(PINOCCHIO.forward_dynamics(other, STILL, controller(other, STILL), STILL)).max() > 1.0
    energies = []
    for controller, rest in ((printed, false_goal), (right, GOAL)):
        positions, velocities = np.moveaxis(closed_loop(controller, np.zeros(3), 1e-3, 1000), 1, 0)
        spring = 0.5 * K_P * ((positions - rest) ** 2).sum(axis=-1)
        energies.append(ARM.kinetic_energy(positions, velocities) + spring)
    # no velocity in the control law, so no damping: the energy oscillates; the steps of 1 ms take 5e-5 of it
    np.testing.assert_allclose(energies[0], energies[0][0], rtol=1e-4)
    assert energies[1][-1] < 0.05 * energies[1][0]


def test_printed_inverse_dynamics_control_oscillates_about_five_sixths_of_the_goal() -> None:
    def printed(q: Array, v: Array) -> Array:
        y = K_D * (0.0 - q) + K_P * (GOAL - q)
        return (ARM.inertia_matrix(q) @ y[:, None])[:, 0] + ARM.bias_force(q, v)

    states = closed_loop(printed, np.zeros(3), 2e-3, 1000)
    time = 2e-3 * np.arange(1001)[:, None]
    swing = GOAL * K_P / (K_P + K_D) * (1 - np.cos(math.sqrt(K_P + K_D) * time))
    # fourth order: a phase error of (ω h)^4/120 = 5e-10 per rad, over 15 rad, of 3 rad
    np.testing.assert_allclose(states[:, 0], swing, rtol=0, atol=1e-7)
    assert np.abs(states[500:, 0] - GOAL).max() > 2.0

    def right(q: Array, v: Array) -> Array:
        y = K_D * (0.0 - v) + K_P * (GOAL - q)
        return (ARM.inertia_matrix(q) @ y[:, None])[:, 0] + ARM.bias_force(q, v)

    # two seconds of a decay with exp(-5 t)
    assert np.abs(closed_loop(right, np.zeros(3), 2e-3, 1000)[-1, 0] - GOAL).max() < 2e-4


INERTIA, FRICTION, WEIGHT = 0.5, 0.15, 1.85  # of the 1-DoF link [kg m², N m s/rad, N m]
THETA = np.array([INERTIA, FRICTION, WEIGHT])


def link(
    state: Array, reference: tuple[float, float], gains: tuple[float, Array], gate: bool
) -> tuple[Array, float]:
    """Slope of (q, q̇, Î, F̂, Ĝ), and σ, under τ = YΘ̂ + K_D σ for a given q̇_r, q̈_r.

    Θ̂˙ = Γ Yᵀ σ, or Γ Yᵀ where the gate is off.
    """
    (rate, acceleration), (damping, adaptation) = reference, gains
    sigma = rate - state[1]
    Y = np.array([acceleration, rate, math.sin(state[0])])
    torque = Y @ state[2:] + damping * sigma
    plant = (torque - FRICTION * state[1] - WEIGHT * math.sin(state[0])) / INERTIA
    slope = np.array([state[1], plant, *(adaptation * Y * (sigma if gate else 1.0))])
    return slope, float(sigma)


def test_estimates_without_the_velocity_error_oscillate_as_in_the_figures() -> None:
    def as_run(time: float, state: Array) -> Array:
        rate = 200.0 * (math.sin(3.14 * time) - state[0])
        acceleration = (1.0 if math.sin(time) >= 0.0 else -1.0) - 200.0 * state[1]
        return link(state, (rate, acceleration), (40.0, np.array([2e-4, 1e-2, 4e-2])), gate=False)[0]

    states = runge_kutta(as_run, np.array([0.0, 0.0, 0.49, 0.14, 1.84]), 1e-3, 10_000)
    # figure 20 read to 4e-4, and what the solver's steps of the figure differ: 1.1e-3 at most
    np.testing.assert_allclose(states[:, 2:].min(axis=0), [0.4498, 0.1049, 1.8400], rtol=0, atol=1.5e-3)
    np.testing.assert_allclose(states[:, 2:].max(axis=0), [0.5295, 0.1736, 1.8627], rtol=0, atol=1.5e-3)
    early, late = (np.ptp(states[start : start + 2000, 2:], axis=0) for start in (2000, 8000))
    assert (late > 0.97 * early).all()  # the amplitude of a period does not decay
    error = np.sin(3.14 * 1e-3 * np.arange(10_001)) - states[:, 0]
    assert np.abs(error[8000:]).max() == pytest.approx(0.0544, abs=5e-5)


def test_estimates_with_the_velocity_error_never_raise_the_lyapunov_function() -> None:
    slope_of_sine, damping, adaptation = 5.0, 5.0, np.array([0.2, 0.2, 2.0])
    omega = 2 * math.pi

    def loop(time: float, state: Array) -> tuple[Array, float]:
        q_d, v_d = math.sin(omega * time), omega * math.cos(omega * time)
        rate = v_d + slope_of_sine * (q_d - state[0])
        acceleration = -(omega**2) * q_d + slope_of_sine * (v_d - state[1])
        return link(state, (rate, acceleration), (damping, adaptation), gate=True)

    states = runge_kutta(lambda t, s: loop(t, s)[0], np.array([0.0, omega, 0.0, 0.0, 0.0]), 2e-3, 5000)
    time = 2e-3 * np.arange(5001)
    sigma = np.array([loop(t, s)[1] for t, s in zip(time, states, strict=True)])
    wrong = ((THETA - states[:, 2:]) ** 2 / adaptation).sum(axis=-1)
    V = 0.5 * INERTIA * sigma**2 + 0.5 * wrong
    assert (np.diff(V) < ROUNDING).all()
    # V̇ = -(F + K_D) σ²; the trapezoidal rule errs by a twelfth of the squared step times slopes of 4e3
    lost = np.trapezoid((FRICTION + damping) * sigma**2, dx=2e-3)
    assert V[0] - V[-1] == pytest.approx(lost, abs=1e-3)
    error = np.abs(np.sin(omega * time) - states[:, 0])
    assert error[-500:].max() < 0.05 * error[:500].max()


def test_printed_estimate_without_integral_leaves_a_steady_error() -> None:
    slope_of_error, damping, adaptation = 5.0, 5.0, np.array([0.2, 0.2, 2.0])
    goal = math.pi / 2

    def rest(integral: bool) -> Array:
        def loop(_: float, state: Array) -> Array:
            rate, acceleration = slope_of_error * (goal - state[0]), -slope_of_error * state[1]
            if not integral:  # Θ̂ = Γ Yᵀ σ itself
                Y = np.array([acceleration, rate, math.sin(state[0])])
                state = np.array([*state[:2], *(adaptation * Y * (rate - state[1]))])
            return link(state, (rate, acceleration), (damping, adaptation), gate=True)[0]

        last: Array = runge_kutta(loop, np.zeros(5), 5e-3, 4000)[-1]
        return last

    q = float(rest(integral=False)[0])
    rate = slope_of_error * (goal - q)  # what is left of σ at rest, and of Y: (0, q̇_r, sin q)
    balance = (damping + adaptation[1] * rate**2 + adaptation[2] * math.sin(q) ** 2) * rate
    assert balance == pytest.approx(WEIGHT * math.sin(q), abs=1e-8)  # 20 s of a decay of 2 1/s and more
    assert goal - q == pytest.approx(0.0527, abs=5e-5)  # its digits
    state = rest(integral=True)
    # 20 s of a decay with γ_3 λ/(K_D λ + γ_3) = 0.37 1/s leave 6e-4 of it
    assert abs(goal - state[0]) < 1e-3 * (goal - q)
    assert state[4] == pytest.approx(WEIGHT, rel=1e-3)  # what holds the link is known at last


@pytest.mark.parametrize("lag", [1e-2, 1e-3, 1e-4])
def test_regressor_with_measured_acceleration_is_unstable_where_the_inertia_is_overrated(lag: float) -> None:
    slope_of_error, damping = 5.0, 5.0

    def growth(estimate: float, measured: bool) -> float:
        """Largest real part [1/s] about the hanging rest; states (q, q̇, q̈ measured with a lag)."""
        stiffness = damping * slope_of_error + (0.0 if measured else FRICTION * slope_of_error)
        resistance = damping + (0.0 if measured else FRICTION + estimate * slope_of_error)
        plant = np.array([-stiffness, -resistance, estimate if measured else 0.0]) / INERTIA
        rows = [np.array([0.0, 1.0, 0.0]), plant, (plant - [0.0, 0.0, 1.0]) / lag]
        return float(np.linalg.eigvals(np.stack(rows)).real.max())

    for estimate in (0.9 * INERTIA, 1.1 * INERTIA):
        assert growth(estimate, measured=False) < -1.0
    assert growth(0.9 * INERTIA, measured=True) < -1.0
    # towards (Î/I - 1)/lag as the lag goes to zero: the better the sensor, the worse
    assert growth(1.1 * INERTIA, measured=True) > 0.2 * 0.1 / lag


def test_steady_error_of_figure_7_is_that_of_a_gravity_with_the_wrong_sign() -> None:
    third = np.array([0.0, 0.0, 1.0])
    names = ("none", "current", "desired", "wrong sign")
    of_q, of_goal = np.array([0.0, 1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0, -1.0])  # of g(q), g(q_d)

    def torque(q: Array, v: Array) -> Array:
        compensation = of_q[:, None] * ARM.gravity_vector(q) + of_goal[:, None] * ARM.gravity_vector(GOAL)
        return np.asarray(compensation + K_P * (GOAL - q) - K_D * v)

    states = closed_loop(torque, np.tile(GOAL, (4, 1)), 2e-3, 1600)
    error = dict(zip(names, GOAL - states[-1, 0], strict=True))
    np.testing.assert_allclose(error["current"], 0.0, rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(error["desired"], 0.0, rtol=0, atol=ROUNDING)
    # 3.2 s of a decay with exp(-4.9 t) leave 1e-7 of it; half of the last digit written here
    np.testing.assert_allclose(error["none"], -0.01924 * third, rtol=0, atol=5e-6)
    np.testing.assert_allclose(error["wrong sign"], -0.03847 * third, rtol=0, atol=5e-6)
    assert error["wrong sign"][2] == pytest.approx(-2 * 0.962145 / K_P, abs=2e-5)  # cos q̃ for 1
    # with reversed gravity, as run, the errors have the other sign: q_3 of figures 6, 7, to a pixel of 0.01
    assert math.pi + error["none"][2] == pytest.approx(3.115, abs=0.01)
    assert math.pi + error["wrong sign"][2] == pytest.approx(3.099, abs=0.01)


def test_printed_set_points_are_incomplete() -> None:
    # 6.4: 0.1 sin(2π) without t stands still
    time = np.linspace(0.0, 3.0, 301)
    assert 0.1 * math.sin(2 * math.pi) == pytest.approx(0.0, abs=1e-15)
    sine = [np.tile(0.1 * np.ones(3), (1, 1)), np.tile(2 * np.pi * np.ones(3), (1, 1)), np.zeros((1, 3))]
    swing = np.ptp(Sine(GOAL[None], *sine).sample(time[:, None])[:, 0, :3], axis=0)
    np.testing.assert_allclose(swing, 0.2, rtol=0, atol=1e-12)
    # 7.1: with q_d1 = π/1 figure 13 would peak at twice the 1.64 rad that it shows
    overshoot = math.exp(-math.pi * K_D / 2 / math.sqrt(K_P - K_D**2 / 4))
    assert (1 + overshoot) * math.pi / 2 == pytest.approx(1.64, abs=0.005)
    assert (1 + overshoot) * math.pi > 3.2
    # 9.1: two numbers are no configuration of three joints; the third as run by the author
    with pytest.raises(ShapeError):
        ARM.forward_kinematics([-np.pi / 3, -0.1])
    pose = ARM.forward_kinematics([-np.pi / 3, -0.1, np.pi / 2])
    np.testing.assert_allclose(pose[:5], [0.0268, -0.4464, 0.39, -1.0472, 0.0], rtol=0, atol=5e-5)
    # 12.1, 14.1, 15.1: five gains, forces or stiffnesses for a pose of six
    with pytest.raises(ValueError, match="shape"):
        np.array([50.0] * 5) * pose


def test_printed_gains_are_not_those_of_the_figures() -> None:
    # figures 11, 12: the reference holds the first waypoint until 0.5 s, the error decays linearly
    waypoints = np.array([[[np.pi / 3, -0.2, np.pi / 3], [-np.pi / 3, -0.1, np.pi / 4]]])
    reference = QuinticWaypoints(np.array([[0.5, 1.0]]), waypoints)

    def highest(damping: float) -> float:
        def slope(time: float, state: Array) -> Array:
            desired = reference.sample(np.array([time]))[0]
            error, rate = desired[0] - state[0], desired[3] - state[1]
            return np.array([state[1], desired[6] + damping * rate + K_P * error])

        return float(runge_kutta(slope, np.zeros(2), 5e-3, 160)[:, 0].max())

    # q_1 of figure 11 rises to 0.90 rad, read to a few hundredths
    assert abs(highest(15.0) - 0.90) < 0.03
    assert abs(highest(K_D) - 0.90) > 0.1
    # figure 36: y at rest against K = 50, read to 1.4 mm
    rest = [(stiffness * -0.34 + 50.0 * -0.44) / (stiffness + 50.0) for stiffness in (75.0, 50.0)]
    assert rest == pytest.approx([-0.380, -0.390], abs=1e-12)
    assert [abs(y - -0.3801) < 1.4e-3 for y in rest] == [True, False]
