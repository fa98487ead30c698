"""Stability limits of integral action: Routh's, and those of a loop that is held for a control period.

The reference is a double integrator whose acceleration is held for a period, once at once and once a period
late. Its spectral radius decides; docs/theory.md states the same limits as inequalities.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from prp_gym.baselines import (
    AdmittanceController,
    AdmittanceSettings,
    Baseline,
    JointInverseDynamicsController,
    JointInverseDynamicsSettings,
    OperationalInverseDynamicsController,
    OperationalInverseDynamicsSettings,
    TimeOptimalController,
    TimeOptimalSettings,
)
from prp_gym.robot import LinkParameters
from tests.support.control_interface import LINK_INTERFACE, PERIOD, POSE_INTERFACE
from tests.support.controller_simulation import hold, simulate

Array = NDArray[np.float64]
Period = Callable[[float, float, float], tuple[float, float]]

INERTIA, TORQUE = 0.5, 30.0
WEIGHTLESS = LinkParameters(inertia=INERTIA, viscous_friction=0.0, gravity_moment=0.0)
NATURAL, DAMPING = 200.0, 280.0  # K_P = 200² 1/s², K_D = 280 1/s


def pid(p: float, d: float, i: float) -> Period:
    """Acceleration times dt², and the change of the integral, for K_P dt², K_D dt and K_I dt³."""
    return lambda x, v, w: (-p * x - d * v - w, i * x)


def profile(gain: float, velocity_gain: float, integral: float) -> Period:
    """The same for λ dt, K_V dt and K_I dt² of time-optimal regulation within its linear zone."""

    def period(x: float, v: float, w: float) -> tuple[float, float]:
        sliding_variable = v + gain * x
        return -gain * v - velocity_gain * sliding_variable - w, integral * sliding_variable

    return period


def radius(period: Period, *, delayed: bool) -> float:
    """Spectral radius of one period of error, error times dt per period, integral and the last action."""
    columns = []
    for x, v, w, last in np.eye(4):
        action, change = period(x, v, w)
        applied = last if delayed else action
        columns.append([x + v + 0.5 * applied, v + applied, w + change, action])
    matrix = np.array(columns).T
    return float(np.abs(np.linalg.eigvals(matrix if delayed else matrix[:3, :3])).max())


def is_stable(p: float, d: float, i: float, *, delayed: bool) -> bool:
    """The inequalities of docs/theory.md."""
    if delayed:
        a_4, a_3, a_2, a_1 = 8 + 4 * d, 8 - 8 * d + 2 * p - i, 4 * d - 4 * p + 3 * i, 2 * p - 3 * i
        return min(a_3, a_2, a_1, i) > 0.0 and a_3 * a_2 * a_1 > a_4 * a_1**2 + a_3**2 * i
    return d < 2.0 and 0.0 < i < p and (4 * d - 2 * p + i) * (p - i) > (4 - 2 * d) * i


@pytest.mark.parametrize("delayed", [False, True])
def test_inequalities_are_those_of_the_eigenvalues(delayed: bool) -> None:
    generator = np.random.default_rng(1)
    answers = []
    for _ in range(2000):
        d, p_share, i_share = generator.uniform(0.01, [1.2, 1.0, 0.8] if delayed else [2.5, 2.5, 1.2])
        p = d * p_share
        i = d * p * i_share
        size = radius(pid(p, d, i), delayed=delayed)
        if abs(size - 1.0) > 1e-6:
            answers.append(size < 1.0)
            assert is_stable(p, d, i, delayed=delayed) == answers[-1], (p, d, i)
    assert 0.05 < np.mean(answers) < 0.95


@pytest.mark.parametrize("delayed", [False, True])
def test_time_optimal_regulation_has_the_limits_of_a_pid_loop(delayed: bool) -> None:
    generator = np.random.default_rng(2)
    answers = []
    for _ in range(2000):
        gain, velocity_gain, integral = generator.uniform(
            0.01, [0.5, 1.0, 0.3] if delayed else [1.0, 2.0, 1.0]
        )
        size = radius(profile(gain, velocity_gain, integral), delayed=delayed)
        p, d, i = gain * velocity_gain + integral, gain + velocity_gain - 0.5 * integral, gain * integral
        if abs(size - 1.0) > 1e-6:
            answers.append(size < 1.0)
            assert is_stable(p, d, i, delayed=delayed) == answers[-1]
    assert 0.05 < np.mean(answers) < 0.95


def limit_of_integral_gain(*, delayed: bool) -> float:
    """Largest stable K_I [1/s³] beside K_P = 200² and K_D = 280 at 500 Hz, by bisection."""
    low, high = 0.0, NATURAL**2 * DAMPING
    for _ in range(60):
        middle = 0.5 * (low + high)
        loop = pid((NATURAL * PERIOD) ** 2, DAMPING * PERIOD, middle * PERIOD**3)
        low, high = (middle, high) if radius(loop, delayed=delayed) < 1.0 else (low, middle)
    return low


def growth(controller: Baseline[Any], *, delayed: bool, seconds: float = 2.0) -> float:
    """How much larger the link's error is at the end of a run than near its start."""
    q, velocity, state, waiting, errors = 0.0, 0.0, None, 0.0, []
    for _ in range(round(seconds / PERIOD)):
        errors.append(abs(1e-5 - q))
        action, state = controller.predict(np.array([q, velocity, 1e-5, 0.0, 0.0]), state)
        acceleration = float(action[0]) * TORQUE / INERTIA
        acceleration, waiting = (waiting, acceleration) if delayed else (acceleration, waiting)
        q += PERIOD * velocity + 0.5 * PERIOD**2 * acceleration
        velocity += PERIOD * acceleration
    quarter = len(errors) // 4
    return max(errors[-quarter:]) / max(errors[:quarter])


def joint_controller(integral_gain: float, natural: float, damping: float) -> JointInverseDynamicsController:
    settings = JointInverseDynamicsSettings(natural**2, damping, integral_gain, model=WEIGHTLESS)
    return JointInverseDynamicsController(LINK_INTERFACE, settings)


@pytest.mark.parametrize("delayed", [False, True])
@pytest.mark.parametrize(("share", "stable"), [(0.9, True), (1.1, False)])
def test_link_is_stable_below_the_sampled_limit_alone(share: float, stable: bool, delayed: bool) -> None:
    gain = share * limit_of_integral_gain(delayed=delayed)
    factor = growth(joint_controller(gain, NATURAL, DAMPING), delayed=delayed)
    assert factor < 0.1 if stable else factor > 2.0


@pytest.mark.parametrize(("share", "stable"), [(0.9, True), (1.1, False)])
def test_link_is_stable_below_the_criterion_of_routh_alone(share: float, stable: bool) -> None:
    # slow gains: the hold lowers the limit by 1.5 %
    natural, damping = math.sqrt(50.0), 10.0
    roots = np.roots([1.0, damping, natural**2, share * damping * natural**2])
    assert (roots.real.max() < 0.0) == stable
    controller = joint_controller(share * damping * natural**2, natural, damping)
    factor = growth(controller, delayed=False, seconds=20.0)
    assert factor < 0.3 if stable else factor > 2.0


def operational(integral_gain: float) -> Baseline[Any]:
    settings = OperationalInverseDynamicsSettings(400.0, 20.0, integral_gain)
    return OperationalInverseDynamicsController(POSE_INTERFACE, settings)


def admittance(integral_gain: float) -> Baseline[Any]:
    settings = AdmittanceSettings(
        inertia=1.0,
        damping=10.0,
        stiffness=20.0,
        proportional_gain=400.0,
        derivative_gain=20.0,
        integral_gain=integral_gain,
    )
    return AdmittanceController(POSE_INTERFACE, settings)


@pytest.mark.parametrize("make", [operational, admittance])
@pytest.mark.parametrize(("share", "stable"), [(0.85, True), (1.15, False)])
def test_arm_in_operational_space_is_stable_below_the_criterion_of_routh_alone(
    make: Callable[[float], Baseline[Any]], share: float, stable: bool
) -> None:
    controller = make(share * 8000.0)  # the hold lowers the limit by 4 %
    goal = np.array([0.4, -0.15, 0.5])
    run = simulate(controller, goal + np.array([0.0, 1e-3, 0.0]), hold(goal), 2.2)
    error = np.abs(run.pose_error[:, 0, :3]).max(axis=1)
    quarter = len(error) // 4
    factor = error[-quarter:].max() / error[:quarter].max()
    assert factor < 0.7 if stable else factor > 1.3


def test_constant_torque_error_is_removed_by_the_integral_alone() -> None:
    wrong = LinkParameters(inertia=INERTIA, viscous_friction=0.0, gravity_moment=0.0)
    for gain, left in ((0.0, 1.85 * math.sin(0.3) / INERTIA / NATURAL**2), (1e6, 0.0)):
        settings = JointInverseDynamicsSettings(NATURAL**2, DAMPING, gain, model=wrong)
        controller = JointInverseDynamicsController(LINK_INTERFACE, settings)
        q, velocity, state = 0.3, 0.0, None
        for _ in range(2000):
            action, state = controller.predict(np.array([q, velocity, 0.3, 0.0, 0.0]), state)
            acceleration = (float(action[0]) * TORQUE - 1.85 * math.sin(q)) / INERTIA
            q += PERIOD * velocity + 0.5 * PERIOD**2 * acceleration
            velocity += PERIOD * acceleration
        assert 0.3 - q == pytest.approx(left, abs=1e-7)  # float32 actions


def test_zone_of_time_optimal_regulation_is_stable_below_its_limit_alone() -> None:
    for integral_gain, stable in ((5e3, True), (4e5, False)):
        loop = profile(80.0 * PERIOD, 160.0 * PERIOD, integral_gain * PERIOD**2)
        assert (radius(loop, delayed=False) < 1.0) == stable
        settings = TimeOptimalSettings(1.0, 0.8, 80.0, 160.0, 50.0, integral_gain, model=WEIGHTLESS)
        factor = growth(TimeOptimalController(LINK_INTERFACE, settings), delayed=False)
        assert factor < 0.1 if stable else factor > 2.0
