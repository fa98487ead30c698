"""Second-order target models against closed forms and a fine Runge-Kutta integration."""

from collections.abc import Callable
from decimal import Decimal, getcontext
from itertools import pairwise, product

import numpy as np
import pytest
from numpy.typing import NDArray

from prp_gym.errors import InvalidValueError, NonFiniteError, ShapeError
from prp_gym.tasks.target_model import Displacement, TargetModel

Array = NDArray[np.float64]

M = np.array([0.5, 1.0, 2.0, 0.1, 1.0, 3.0])
K_D = np.array([10.0, 1.0, 0.0, 4.0, 20.0, 0.5])
K_P = np.array([50.0, 50.0, 8.0, 40.0, 100.0, 0.0])
START = Displacement(np.array([0.1, -0.2, 0.3, 0.0, 1.0, 0.5]), np.array([1.0, 0.0, -2.0, 0.3, 0.0, -1.0]))


def runge_kutta(force: Callable[[float], Array], duration: float, steps: int) -> tuple[Array, Array]:
    """z and ż at the end, from START; classical fourth order."""
    state, h = np.array(START), duration / steps

    def slope(time: float, x: Array) -> Array:
        return np.array([x[1], (force(time) - K_D * x[1] - K_P * x[0]) / M])

    for step in range(steps):
        time = step * h
        a = slope(time, state)
        b = slope(time + h / 2, state + h / 2 * a)
        c = slope(time + h / 2, state + h / 2 * b)
        d = slope(time + h, state + h * c)
        state = state + h / 6 * (a + 2 * b + 2 * c + d)
    return state[0], state[1]


@pytest.mark.parametrize("period", [0.002, 0.02, 0.3])
def test_linear_force_gives_what_a_fine_integration_gives(period: float) -> None:
    model = TargetModel(M, K_D, K_P, period)
    knots = np.random.default_rng(0).uniform(-5.0, 5.0, (5, 6))
    at = START
    for begin, end in pairwise(knots):
        at = model.advance(at, begin, end)

    # one Runge-Kutta run over all knots, whose force is linear between them
    def force(time: float) -> Array:
        index = min(int(time / period), 3)
        share = time / period - index
        return np.asarray((1 - share) * knots[index] + share * knots[index + 1])

    reference = np.array(runge_kutta(force, 4 * period, 4 * 2000))
    # the fastest mode, 40/s, in steps of at most 0.15 ms: (ωh)⁴ = 1.3e-9, and less than that is left
    np.testing.assert_allclose(np.array(at), reference, rtol=1e-8, atol=1e-9)


def test_undamped_axis_swings_as_a_cosine() -> None:
    model = TargetModel(np.ones(6), np.zeros(6), np.full(6, 9.0), 0.01)
    at, none = Displacement(np.full(6, 0.2), np.zeros(6)), np.zeros(6)
    for _ in range(1000):
        at = model.advance(at, none, none)
    # a thousand products of a rotation: rounding of 1e-16 each
    np.testing.assert_allclose(at.value, 0.2 * np.cos(30.0), atol=1e-12)
    np.testing.assert_allclose(at.rate, -0.6 * np.sin(30.0), atol=1e-12)


def test_free_mass_under_a_ramp_moves_as_a_cubic() -> None:
    model = TargetModel(np.full(6, 2.0), np.zeros(6), np.zeros(6), 0.5)
    at = model.advance(Displacement.zero(()), np.zeros(6), np.full(6, 3.0))
    np.testing.assert_allclose(at.value, 3.0 * 0.5**2 / 6 / 2.0, rtol=1e-13)
    np.testing.assert_allclose(at.rate, 3.0 * 0.5 / 2 / 2.0, rtol=1e-13)


def test_held_force_settles_at_the_static_displacement() -> None:
    model = TargetModel(M, K_D + 1.0, K_P, 0.1)
    force = np.array([1.0, -2.0, 3.0, -4.0, 5.0, 0.0])
    at = Displacement.zero(())
    for _ in range(3000):
        at = model.advance(at, force, force)
    expected = model.static_displacement(force)
    np.testing.assert_allclose(expected[:5], force[:5] / K_P[:5], rtol=1e-15)
    np.testing.assert_allclose(at.value, expected, atol=1e-12)
    assert model.static_displacement(np.ones(6))[5] == 0.0  # no stiffness there


def test_acceleration_is_what_mass_damper_and_spring_leave_of_the_force() -> None:
    model, force = TargetModel(M, K_D, K_P, 1e-6), np.arange(6.0)
    after = model.advance(START, force, force)
    # forward difference over 1 µs: half a period of the jerk, up to 1e4
    difference = (after.rate - START.rate) / 1e-6
    np.testing.assert_allclose(model.acceleration(START, force), difference, rtol=1e-4, atol=1e-2)
    balance = M * model.acceleration(START, force) + K_D * START.rate + K_P * START.value
    np.testing.assert_allclose(balance, force, atol=1e-13)


def test_models_of_many_episodes_advance_together() -> None:
    model, generator = TargetModel(M, K_D, K_P, 0.002), np.random.default_rng(1)
    value, rate, begin, end = generator.uniform(-1.0, 1.0, (4, 7, 6))
    together = model.advance(Displacement(value, rate), begin, end)
    assert together.value.shape == together.rate.shape == (7, 6)
    for row in range(7):
        alone = model.advance(Displacement(value[row], rate[row]), begin[row], end[row])
        np.testing.assert_allclose(alone, (together.value[row], together.rate[row]), rtol=1e-13, atol=1e-15)


def in_eighty_digits(inertia: float, damping: float, stiffness: float, period: float) -> tuple[Array, float]:
    """The map of (z, ż, f at the start, f at the end) to (z, ż) at the end, and the norm of its argument."""
    getcontext().prec = 80
    m, d, k, t = (Decimal(number) for number in (inertia, damping, stiffness, period))
    argument = np.full((4, 4), Decimal(0))
    argument[0, 1] = argument[2, 3] = t
    argument[1, :3] = [-k / m * t, -d / m * t, t / m]
    norm = max(sum(abs(entry) for entry in row) for row in argument)
    halvings = max(0, norm.adjusted() + 1) * 4
    small = argument / Decimal(2) ** halvings
    term = total = np.array([[Decimal(int(row == column)) for column in range(4)] for row in range(4)])
    for order in range(1, 60):
        term = term.dot(small) / order
        total = total + term
    for _ in range(halvings):
        total = total.dot(total)
    total[:, 3] = total[:, 3] / t
    total[:, 2] = total[:, 2] - total[:, 3]
    return total[:2].astype(np.float64), float(norm)


@pytest.mark.parametrize("period", [0.001, 0.02, 1.0])
@pytest.mark.parametrize("inertia", [1e-3, 0.5, 1e3])
def test_period_is_exact_for_all_targets_that_a_task_may_ask_for(inertia: float, period: float) -> None:
    for axes in product((0.0, 10.0, 1e5), (0.0, 50.0, 1e6)):
        model = TargetModel(np.full(6, inertia), np.full(6, axes[0]), np.full(6, axes[1]), period)
        exact, norm = in_eighty_digits(inertia, *axes, period)
        for column, inputs in enumerate(np.eye(4)[:, :, None] * np.ones(6)):
            value, rate, begin, end = inputs
            found = np.array(model.advance(Displacement(value, rate), begin, end))
            # rounding of the argument, 1e-16 of its norm; the squarings make some hundred times that
            bound = 4e-14 * (norm + 1.0) * np.abs(exact[:, column]).max()
            np.testing.assert_allclose(found, np.repeat(exact[:, [column]], 6, axis=1), rtol=0, atol=bound)


def test_axes_of_one_model_do_not_touch_each_other() -> None:
    hard = TargetModel(M, K_D, np.array([1e6, 1e6, 1e6, 1e6, 1e6, 50.0]), 0.02)
    soft = TargetModel(M, K_D, np.full(6, 50.0), 0.02)
    found, alone = (model.advance(START, np.ones(6), np.zeros(6)) for model in (hard, soft))
    # 22 squarings for the hard axes' sake: 2^22 roundings of 1e-16
    np.testing.assert_allclose(np.array(found)[:, 5], np.array(alone)[:, 5], rtol=1e-9)


@pytest.mark.parametrize("name", ["damping", "stiffness"])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_model_with_a_number_that_is_not_finite_is_refused(name: str, value: float) -> None:
    numbers = {"inertia": M, "damping": K_D, "stiffness": K_P} | {name: np.array([*np.ones(5), value])}
    with pytest.raises(NonFiniteError, match=f"target {name} is"):
        TargetModel(**numbers, period=0.002)


def test_model_whose_motion_is_not_finite_is_refused() -> None:
    with pytest.raises(InvalidValueError, match=r"target model is .* whose motion over a period is finite"):
        TargetModel(inertia=np.full(6, 1e-300), damping=np.ones(6), stiffness=np.full(6, 1e29), period=0.002)


@pytest.mark.parametrize("inertia", [np.zeros(6), np.array([1.0, 1.0, 1.0, 1.0, 1.0, -1.0])])
def test_model_without_inertia_is_refused(inertia: Array) -> None:
    with pytest.raises(InvalidValueError, match="target inertia"):
        TargetModel(inertia, K_D, K_P, 0.002)


def test_wrong_sizes_and_periods_are_refused() -> None:
    with pytest.raises(ShapeError, match="target damping"):
        TargetModel(M, np.ones(3), K_P, 0.002)
    with pytest.raises(InvalidValueError, match="period"):
        TargetModel(M, K_D, K_P, 0.0)


@pytest.mark.parametrize("name", ["damping", "stiffness"])
def test_model_that_pushes_is_refused(name: str) -> None:
    numbers = {"inertia": M, "damping": K_D, "stiffness": K_P} | {name: np.array([*np.ones(5), -1e-9])}
    with pytest.raises(InvalidValueError, match=rf"target {name} is .*; allowed: 0, or at least 1e-30"):
        TargetModel(**numbers, period=0.002)
