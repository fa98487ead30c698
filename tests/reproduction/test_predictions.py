"""Closed forms of the reproduction against numbers and solutions that were found without them."""

import math
from typing import Any

import numpy as np
import pytest

from prp_gym.errors import InvalidValueError
from prp_gym.reproduction import load_catalogue
from prp_gym.reproduction.predictions import FORMULAS, error_decay

load_catalogue()  # enters every formula

STEP = [math.pi / 3, -0.2, math.pi / 3]


def predict(name: str, **arguments: Any) -> Any:
    return FORMULAS[name].compute(**arguments)


def gains(K_P: float, K_D: float) -> dict[str, float]:
    return {"proportional_gain": K_P, "derivative_gain": K_D}


@pytest.mark.parametrize(
    ("name", "arguments", "expected"),
    [
        ("second_order_overshoot", gains(50.0, 10.0), [4.32, 4.32, 4.32]),
        ("second_order_overshoot", gains(500.0, 35.0), [1.93, 1.93, 1.93]),
        ("second_order_peak_time", gains(50.0, 10.0), [0.628, 0.628, 0.628]),
        ("second_order_peak_time", gains(500.0, 35.0), [0.226, 0.226, 0.226]),
        ("error_after_step", {"step": STEP, "time": 0.5, **gains(50.0, 10.0)}, [-0.0174, 0.0033, -0.0174]),
        ("error_after_step", {"step": STEP, "time": 0.5, **gains(50.0, 15.0)}, [0.165, -0.0315, 0.165]),
        ("error_after_step", {"step": STEP, "time": 1.0, **gains(50.0, 10.0)}, [-0.0048, 0.0009, -0.0048]),
    ],
)
def test_free_space_gives_the_printed_numbers(
    name: str, arguments: dict[str, Any], expected: list[float]
) -> None:
    found = predict(name, **arguments)
    for value, printed in zip(found, expected, strict=True):
        digits = len(f"{printed!r}".partition(".")[2])
        assert value == pytest.approx(printed, abs=0.5001 * 10.0**-digits)  # half of the last printed digit


# f = K K_P/(K + K_P) d, to half of the last printed digit
@pytest.mark.parametrize(
    ("K_P", "K", "depth", "force"),
    [
        (50.0, 1.0, 0.1, 0.09804),
        (50.0, 50.0, 0.1, 2.5),
        (50.0, 1000.0, 0.1, 4.7619),
        (75.0, 1.0, 0.1, 0.0987),
        (75.0, 50.0, 0.1, 3.0),
        (75.0, 1000.0, 0.1, 6.977),
        (20.0, 1.0, 0.05, 0.0476),
        (20.0, 25.0, 0.05, 0.5556),
        (20.0, 50.0, 0.05, 0.7143),
        (20.0, 1000.0, 0.05, 0.9804),
    ],
)
def test_two_springs_give_the_printed_forces_and_balance(
    K_P: float, K: float, depth: float, force: float
) -> None:
    springs = {"controller_stiffness": K_P, "surface_stiffness": K}
    found = predict("spring_force", depth=depth, **springs)
    assert found == pytest.approx(force, abs=5e-5 if force < 5.0 else 5e-4)
    position = predict("spring_position", desired=-0.34, surface=-0.34 - depth, **springs)
    # to rounding: each spring carries the force
    assert K * (position + 0.34 + depth) == pytest.approx(found, rel=1e-9)
    assert K_P * (-0.34 - position) == pytest.approx(found, rel=1e-9)


@pytest.mark.parametrize(("origin", "force"), [(-0.54, 0.9706), (0.0, 1.0235)])
def test_force_without_an_integral_depends_on_the_origin(origin: float, force: float) -> None:
    found = predict(
        "force_without_integral",
        origin=origin,
        desired_force=1.0,
        surface=-0.44,
        surface_stiffness=5.0,
        force_gain=10.0,
    )
    assert found == pytest.approx(force, abs=5e-5)  # half of the last printed digit


def test_slow_force_mode_is_the_smallest_of_three_poles() -> None:
    found = predict(
        "slowest_force_mode",
        force_gain=10.0,
        integral_gain=5.0,
        proportional_gain=50.0,
        derivative_gain=100.0,
        mass=0.5,
        surface_stiffness=5.0,
    )
    assert found == pytest.approx(0.50, abs=5e-3)  # the poles are at -170, -29.4 and -0.50
    # to rounding: sum of the poles -K_D/M_d, product -K_P K K_I/M_d
    others = np.roots([1.0, 200.0 - found, (200.0 - found) * -found + 5100.0])
    assert sorted(others) == pytest.approx([-170.0, -29.4], abs=0.2)
    assert float(np.prod(others)) * found == pytest.approx(2500.0, rel=1e-9)


def test_surface_answers_with_the_desired_force_where_it_is_said_to() -> None:
    found = predict("pressed_position", surface=-0.3078, desired_force=0.5, surface_stiffness=50.0)
    assert found == pytest.approx(-0.2978, abs=1e-12)


def test_error_decay_is_the_damped_cosine() -> None:
    time = np.linspace(0.0, 2.0, 100)
    expected = np.exp(-5.0 * time) * (np.cos(5.0 * time) + np.sin(5.0 * time))  # K_P = 50, K_D = 10
    np.testing.assert_allclose(error_decay(time, 50.0, 10.0), expected, atol=1e-12)  # rounding


def test_error_decay_holds_at_and_beyond_critical_damping() -> None:
    time = np.linspace(0.0, 3.0, 100)
    critical = (1.0 + 5.0 * time) * np.exp(-5.0 * time)  # K_P = 25, K_D = 10
    np.testing.assert_allclose(error_decay(time, 25.0, 10.0), critical, atol=1e-14)  # rounding
    # on both sides of it the solution changes in proportion to the change of K_P
    for K_P in (25.0 - 1e-9, 25.0 + 1e-9):
        np.testing.assert_allclose(error_decay(time, K_P, 10.0), critical, atol=1e-9)
    overdamped = (4.0 * np.exp(-time) - np.exp(-4.0 * time)) / 3.0  # K_P = 4, K_D = 5: roots -1 and -4
    np.testing.assert_allclose(error_decay(time, 4.0, 5.0), overdamped, atol=1e-14)  # rounding
    assert error_decay(1000.0, 1.0, 100.0) == pytest.approx(math.exp(-10.001), rel=1e-4)  # the slow root's


@pytest.mark.parametrize("name", ["second_order_overshoot", "second_order_peak_time"])
@pytest.mark.parametrize("K_D", [10.0, 11.0])
def test_response_that_does_not_swing_has_no_peak(name: str, K_D: float) -> None:
    with pytest.raises(InvalidValueError, match="derivative_gain") as caught:
        predict(name, **gains(25.0, K_D))
    assert "below 2√K_P = 10" in str(caught.value)


@pytest.mark.parametrize("name", ["overshoot", "peak_time"])
@pytest.mark.parametrize(
    ("K_P", "K_D", "word"),
    [
        (0.0, 1.0, "proportional_gain"),
        (-4.0, 1.0, "proportional_gain"),
        (math.inf, 1.0, "proportional_gain"),
        (50.0, 0.0, "derivative_gain"),
        (50.0, math.nan, "derivative_gain"),
    ],
)
def test_response_that_does_not_decay_is_refused(name: str, K_P: float, K_D: float, word: str) -> None:
    with pytest.raises(InvalidValueError, match=word):
        predict(f"second_order_{name}", **gains(K_P, K_D))


def test_every_formula_says_what_it_is_and_where_it_is_from() -> None:
    assert len(FORMULAS) >= 8
    for name, formula in FORMULAS.items():
        assert formula.name == name
        assert len(formula.text) > 10
        assert formula.source.startswith(("[S]", "[R]"))
