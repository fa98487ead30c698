"""Model-predictive control: the regulator near the goal, limits and stops, disturbances, and its observer."""

import itertools
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from prp_gym.baselines import ModelPredictiveController, ModelPredictiveSettings
from prp_gym.baselines.model_predictive import ITERATIONS
from prp_gym.baselines.predictive import iteration
from prp_gym.baselines.predictive.formulas import KNOTS
from prp_gym.errors import UntraceableError
from prp_gym.evaluation.compiled_controller import CompiledController
from prp_gym.robot import NOMINAL, LinkParameters
from tests.support.control_interface import INTERFACE, LIMIT, LINK_INTERFACE, PERIOD
from tests.support.controller_simulation import hold, quintic, simulate

Array = NDArray[np.float64]

INERTIA, TORQUE = 0.5, 30.0
WEIGHTLESS = LinkParameters(inertia=INERTIA, viscous_friction=0.0, gravity_moment=0.0)
ARM = {
    "position_weight": [1000.0, 15000.0, 300.0],
    "velocity_weight": [0.03, 0.05, 0.001],
    "error_scale": [0.5, 0.06, 0.5],
    "horizon": 0.2,
}
STARTS = np.random.default_rng(4).uniform([-2.0, -0.28, -2.0], [2.0, -0.02, 2.0], (6, 3))
GOALS = np.random.default_rng(3).uniform([-2.0, -0.28, -2.0], [2.0, -0.02, 2.0], (6, 3))


def link(**settings: Any) -> ModelPredictiveController:
    chosen = {
        "position_weight": 2000.0,
        "velocity_weight": 0.5,
        "error_scale": 0.3,
        "horizon": 0.2,
        **settings,
    }
    return ModelPredictiveController(LINK_INTERFACE, ModelPredictiveSettings(model=WEIGHTLESS, **chosen))


def arm(**settings: Any) -> ModelPredictiveController:
    return ModelPredictiveController(INTERFACE, ModelPredictiveSettings(**{**ARM, **settings}))


def observation(q: float, velocity: float, goal: float = 0.0) -> dict[str, Array]:
    values = (q, velocity, goal, 0.0, 0.0)
    return {name: np.array([value]) for name, value in zip(LINK_INTERFACE.layout.names, values, strict=True)}


def feedback(controller: ModelPredictiveController, **state: Any) -> Array:
    """Torque per position and velocity error of the link, near its goal."""
    size = 1e-6
    gains = []
    for q, velocity in ((size, 0.0), (0.0, size)):
        seen = observation(q, velocity)
        torque, _ = controller.control(seen, controller.initial_state(seen))
        gains.append(float(torque[0]) / size)
    return np.array(gains)


def riccati_gain(weight: float, rate_weight: float, period: float) -> Array:
    """The gain of a sampled double integrator over an infinite horizon, by iterating the Riccati equation.

    As in the plan, an interval costs its duration times the cost of the state at its end.
    """
    A = np.array([[1.0, period], [0.0, 1.0]])
    B = np.array([[0.5 * period**2], [period]]) / INERTIA
    Q, R = period * np.diag([weight, rate_weight]), period / TORQUE**2
    P = np.zeros((2, 2))
    for _ in range(20000):
        S = P + Q
        gain = np.linalg.solve(R + B.T @ S @ B, B.T @ S @ A)
        P = A.T @ S @ (A - B @ gain)
    return np.asarray(-gain[0])


def test_near_the_goal_the_gains_are_those_of_the_linear_quadratic_regulator() -> None:
    # a uniform plan of 32 ms, which 1/ω = 10 ms and the cost after the horizon make long enough
    found = feedback(link(horizon=0.0))
    np.testing.assert_allclose(found, riccati_gain(2000.0, 0.5, PERIOD), rtol=2e-2)


@pytest.mark.parametrize("horizon", [0.1, 0.2, 0.4])
def test_longer_intervals_further_on_hardly_change_the_gains(horizon: float) -> None:
    # intervals of more than 1/ω come after the errors have decayed
    np.testing.assert_allclose(feedback(link(horizon=horizon)), riccati_gain(2000.0, 0.5, PERIOD), rtol=0.1)


def test_poles_are_about_those_of_the_continuous_regulator() -> None:
    r = (INERTIA / TORQUE) ** 2
    expected = [np.sqrt(2000.0 / r), np.sqrt((0.5 + 2.0 * np.sqrt(2000.0 * r)) / r)]
    # at a finer period the sampled gains approach them: here 1/ω is 6 periods
    gain = riccati_gain(2000.0, 0.5, 1e-5)
    np.testing.assert_allclose(-gain / INERTIA, expected, rtol=2e-3)


def loop_of_the_observer(gain: float, steps: int) -> Array:
    """The disturbance torque that the link's controller estimates without there being one, from 1e-3 N m."""
    controller, q, velocity, estimates = link(observer_gain=gain), 0.0, 0.0, []
    seen = observation(q, velocity)
    plan, disturbance, expected = controller.initial_state(seen)
    state: tuple[Array, ...] = (plan, disturbance + 1e-3, expected)
    for _ in range(steps):
        torque, state = controller.control(observation(q, velocity), state)
        acceleration = float(torque[0]) / INERTIA
        q += PERIOD * velocity + 0.5 * PERIOD**2 * acceleration
        velocity += PERIOD * acceleration
        estimates.append(float(state[1][0]))
    return np.array(estimates)


@pytest.mark.parametrize("share", [0.1, 0.5, 1.5, 1.9])
def test_error_of_the_observer_has_one_factor_per_period(share: float) -> None:
    estimates = loop_of_the_observer(share / PERIOD, 20)
    # from the first estimate on, which was made before a torque acted
    np.testing.assert_allclose(estimates, 1e-3 * (1.0 - share) ** np.arange(20), rtol=1e-6, atol=1e-12)


@pytest.mark.parametrize(("share", "is_stable"), [(1.95, True), (2.05, False)])
def test_loop_is_stable_up_to_the_limit_of_the_observer_gain_alone(share: float, is_stable: bool) -> None:
    estimates = np.abs(loop_of_the_observer(share / PERIOD, 200))
    assert (estimates[-1] < 1e-2 * estimates[0]) == is_stable
    assert (estimates[-1] > 1e2 * estimates[0]) != is_stable


@pytest.mark.parametrize(("observer_gain", "remains"), [(0.0, True), (30.0, False)])
def test_only_the_observer_removes_what_link_mass_errors_leave(observer_gain: float, remains: bool) -> None:
    heavy = NOMINAL.with_masses((1.5, 1.0, 1.1))
    run = simulate(
        arm(observer_gain=observer_gain), (0.0, -0.1, 0.0), hold((0.5, -0.2, 0.3)), 1.5, plants=[heavy]
    )
    # 0.3 N m of the third link's weight over K_P = √Q_P τ_max = 170 N m/rad
    assert (abs(run.joint_error[-1, 0, 2]) > 1e-3) == remains
    if not remains:
        np.testing.assert_allclose(run.joint_error[-1], 0.0, atol=1e-6)


def test_arm_reaches_every_goal_within_limits_and_stops() -> None:
    run = simulate(arm(), STARTS, hold(GOALS), 1.2)
    np.testing.assert_allclose(run.joint_error[-1], 0.0, atol=1e-5)
    assert (np.abs(run.torque) <= LIMIT * (1.0 + 1e-6)).all()  # actions are of single precision
    assert (np.abs(run.torque) > 0.99 * LIMIT).any(axis=(0, 1)).all()
    # stops cost, but do not bind: 1 cm and 0.1 rad
    margin = np.array([0.1, 0.01, 0.1])
    assert (run.joint_position > NOMINAL.joint_lower - margin).all()
    assert (run.joint_position < NOMINAL.joint_upper + margin).all()


def test_smooth_motion_is_followed() -> None:
    run = simulate(arm(), (0.0, -0.1, 0.0), quintic((0.0, -0.1, 0.0), (1.0, -0.2, -1.0), 1.0), 1.2)
    # held for 2 ms, the torque is behind by 1 ms; the largest jerk is 60 rad/s³
    assert (np.abs(run.joint_error) < [2e-3, 5e-4, 2e-3]).all()


def test_only_the_applied_torque_exceeds_the_planned_share() -> None:
    controller = link(planned_share=0.5)
    seen = observation(0.0, 0.0, goal=2.0)
    state = controller.initial_state(seen)
    for _ in range(3):
        torque, state = controller.control(seen, state)
    assert abs(float(torque[0])) == pytest.approx(TORQUE)
    assert np.abs(state[0][0]) == pytest.approx(TORQUE)
    assert (np.abs(state[0][1:]) <= 0.5 * TORQUE * (1.0 + 1e-12)).all()
    assert np.abs(state[0][1:]).max() == pytest.approx(0.5 * TORQUE)


def test_disturbance_is_held_while_a_torque_is_at_its_limit() -> None:
    controller = link(observer_gain=100.0)
    far, near = observation(0.0, 0.0, goal=2.0), observation(0.0, 0.0, goal=1e-3)
    for seen, is_held in ((far, True), (near, False)):
        plan, disturbance, expected = controller.initial_state(seen)
        _, after = controller.control(seen, (plan, disturbance, expected - 0.01))
        # λ B times 0.01 rad/s
        assert after[1][0] == pytest.approx(0.0 if is_held else 100.0 * INERTIA * 0.01)


def test_estimate_stays_within_the_actuator_limits() -> None:
    controller, seen = link(observer_gain=1e6), observation(0.0, 0.0)
    _, disturbance, expected = controller.initial_state(seen)
    estimate = controller._estimated(
        {name: part[None] for name, part in seen.items()}, disturbance[None], expected[None] - 1.0
    )
    np.testing.assert_array_equal(estimate, [[TORQUE]])


def test_numpy_alone_gives_the_same_torques(monkeypatch: pytest.MonkeyPatch) -> None:
    with_compiler = simulate(arm(), STARTS, hold(GOALS), 0.02)
    monkeypatch.setattr(iteration, "compiles_by_default", lambda: False)
    monkeypatch.setattr(iteration, "improve_compiled", lambda *_: pytest.fail("compiled"))
    np.testing.assert_array_equal(simulate(arm(), STARTS, hold(GOALS), 0.02).torque, with_compiler.torque)


def test_plan_is_improved_by_each_iteration_of_a_period(monkeypatch: pytest.MonkeyPatch) -> None:
    costs, improve = [], iteration.improve

    def counted(*arguments: Any) -> iteration.Improved:
        costs.append(improve(*arguments))
        return costs[-1]

    monkeypatch.setattr("prp_gym.baselines.model_predictive.improve", counted)
    controller, seen = link(), observation(0.0, 0.0, goal=1.0)
    _, state = controller.control(seen, controller.initial_state(seen))
    assert len(costs) == ITERATIONS
    for before, after in itertools.pairwise(costs):
        assert after.cost[0, 0] == before.cost[0, 1]
    np.testing.assert_array_equal(state[0], costs[-1].torque.reshape(KNOTS))  # τ_d is zero without weight


@pytest.mark.parametrize("alone", [False, True])
def test_plan_that_diverges_is_given_up(alone: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """An arm without joint stops reaches speeds that the actuators cannot brake."""
    if alone:
        monkeypatch.setattr(iteration, "compiles_by_default", lambda: False)
    controller, size = arm(), INTERFACE.layout.size
    observation = np.zeros((5, size))
    where, speed = (INTERFACE.layout.index(name) for name in ("joint_position", "joint_velocity"))
    observation[:, where] = [-2.4, -0.8, 4.2]
    observation[:, speed] = np.outer([0.0, 1e2, 1e3, 1e4, 1e6], [-0.16, -0.23, 1.0])
    state = None
    for _ in range(3):  # each checks the state that it is given
        action, state = controller.predict(observation, state)
    assert state is not None
    plans = state[0]
    assert np.isfinite(action).all()
    assert plans[0].any()
    assert not plans[-1].any()


def test_optimisation_is_not_traced_into_compiled_episodes() -> None:
    with pytest.raises(UntraceableError, match="the optimisation of a plan"):
        CompiledController(arm(), np.zeros((2, INTERFACE.layout.size)))
