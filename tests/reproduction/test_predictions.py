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
# target models of impedance and admittance control along y: M, K_D, K_P
FIGURES, PRINTED, FRAME = [0.5, 25.0, 75.0], [0.5, 10.0, 50.0], [1.0, 10.0, 20.0]


def predict(name: str, **arguments: Any) -> Any:
    return FORMULAS[name].compute(**arguments)


def gains(K_P: float, K_D: float) -> dict[str, float]:
    return {"proportional_gain": K_P, "derivative_gain": K_D}


@pytest.mark.parametrize(
    ("name", "arguments", "expected"),
    [
        ("joint_pd_sag", {"desired": math.pi, "proportional_gain": 50.0}, [0.0, 0.0, -0.01924]),
        ("second_order_overshoot", gains(50.0, 10.0), [4.32, 4.32, 4.32]),
        ("second_order_overshoot", gains(500.0, 35.0), [1.93, 1.93, 1.93]),
        ("second_order_peak_time", gains(50.0, 10.0), [0.628, 0.628, 0.628]),
        ("second_order_peak_time", gains(500.0, 35.0), [0.226, 0.226, 0.226]),
        ("error_after_step", {"step": STEP, "time": 0.5, **gains(50.0, 10.0)}, [-0.0174, 0.0033, -0.0174]),
        ("error_after_step", {"step": STEP, "time": 0.5, **gains(50.0, 15.0)}, [0.165, -0.0315, 0.165]),
        ("error_after_step", {"step": STEP, "time": 1.0, **gains(50.0, 10.0)}, [-0.0048, 0.0009, -0.0048]),
        ("first_torque", {"step": STEP, "proportional_gain": 50.0}, [31.22, -47.93, 1.788]),
        ("first_torque", {"step": STEP, "proportional_gain": 500.0}, [312.2, -479.3, 9.2]),
        ("holding_torque", {"joint_position": [0.0, 0.0, 0.0]}, [0.0, 0.0, 0.9621]),
        ("holding_torque", {"joint_position": [0.3, -0.1, math.pi]}, [0.0, 0.0, -0.9621]),
        (
            "pose",
            {"joint_position": [-math.pi / 3, -0.1, math.pi / 2], "components": [0, 1, 2, 3, 4, 5]},
            [0.02679, -0.44641, 0.39, -1.0472, 0.0, 1.5708],
        ),
        (
            "pose",
            {"joint_position": [-math.pi / 2, -0.1, -math.pi / 6], "components": [4, 0]},
            [2.0944, -0.40785],
        ),
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


@pytest.mark.parametrize(("K_P", "K_D"), [(50.0, 10.0), (500.0, 35.0), (50.0, 15.0)])
def test_settling_time_is_when_the_response_enters_its_band_for_good(K_P: float, K_D: float) -> None:
    when = float(predict("second_order_settling_time", **gains(K_P, K_D))[0])
    later = np.linspace(when, when + 3.0, 30001)
    assert abs(float(error_decay(when, K_P, K_D))) == pytest.approx(0.02, abs=2e-5)  # 10 µs at 2 1/s
    assert (np.abs(error_decay(later, K_P, K_D)) <= 0.02).all()
    assert abs(float(error_decay(when - 1e-3, K_P, K_D))) > 0.02


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


@pytest.mark.parametrize(
    ("K_P", "K_D", "when"),
    # (1 + x) exp(-x) = 0.02 at x = 5.8339; roots -1, -4: 4/3 exp(-t) = 0.02 but for exp(-4t); root -0.010001
    [
        (25.0, 10.0, 5.83392 / 5.0),
        (4.0, 5.0, math.log(200.0 / 3.0)),
        (1.0, 100.0, math.log(50.005) / 0.010001),
    ],
)
def test_settling_time_holds_at_and_beyond_critical_damping(K_P: float, K_D: float, when: float) -> None:
    # a sample in a million of ten time constants, and the digits above
    assert predict("second_order_settling_time", **gains(K_P, K_D)) == pytest.approx([when] * 3, rel=1e-5)


@pytest.mark.parametrize("name", ["second_order_overshoot", "second_order_peak_time"])
@pytest.mark.parametrize("K_D", [10.0, 11.0])
def test_response_that_does_not_swing_has_no_peak(name: str, K_D: float) -> None:
    with pytest.raises(InvalidValueError, match="derivative_gain") as caught:
        predict(name, **gains(25.0, K_D))
    assert "below 2√K_P = 10" in str(caught.value)


@pytest.mark.parametrize("name", ["overshoot", "peak_time", "settling_time"])
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


def test_link_mass_errors_rest_where_the_torques_balance() -> None:
    error = predict(
        "rest_error_with_link_mass_errors",
        desired=[0.0, 0.0, 0.0],
        masses=[0.9, 0.5, 0.7],
        proportional_gain=50.0,
    )
    # B̂ by hand for m_2 = 0.5, m_3 = 0.7: a_1 = 0.4, c_3 = 0.12, solid cylinder of 0.02 m and 0.24 m
    s, c = math.sin(-error[2]), math.cos(-error[2])
    b_12, b_13, b_22, b_23 = -0.4 * 1.2, 0.7 * 0.4 * 0.12 * s, 1.2, -0.7 * 0.12 * s
    b_33 = 0.7 * (0.12**2 + (3 * 0.02**2 + 0.24**2) / 12)
    mass = 2710.0 * math.pi * 0.02**2 * 0.24
    weight = (mass - 0.7) * 9.81 * 0.12 * c
    second = b_12 * error[0] + b_22 * error[1] + b_23 * error[2]
    third = b_13 * error[0] + b_23 * error[1] + b_33 * error[2]
    assert second == pytest.approx(0.0, abs=1e-12)  # rounding
    assert 50.0 * third == pytest.approx(weight, rel=1e-9)  # rounding


def analytic_peak(K: float) -> float:
    """Compliance control, K_P = 50, K_D = 10, from -0.54 m to -0.34 m: free swing, then the pressed one."""
    mass = 0.73170 + 0.817320

    def swing(k: float, rest: float, y: float, v: float) -> Any:
        decay = 5.0 / mass
        rate = math.sqrt(k / mass - decay**2)
        A = complex(y - rest, -(v + decay * (y - rest)) / rate)
        root = complex(-decay, rate)
        return lambda t: (rest + (A * np.exp(root * t)).real, (A * root * np.exp(root * t)).real)

    time = np.linspace(0.0, 1.0, 1_000_001)
    position, velocity = swing(50.0, -0.34, -0.54, 0.0)(time)
    touch = int(np.argmax(position >= -0.44))
    rest = (50.0 * -0.34 + K * -0.44) / (50.0 + K)
    return K * float(swing(50.0 + K, rest, -0.44, velocity[touch])(time)[0].max() + 0.44)


@pytest.mark.parametrize("K", [1.0, 50.0, 1000.0])
def test_compliance_peaks_as_the_two_linear_swings_do(K: float) -> None:
    found = predict(
        "compliance_peak_force",
        surface_stiffness=K,
        surface=-0.44,
        start=-0.54,
        desired=-0.34,
        **gains(50.0, 10.0),
    )
    assert found == pytest.approx(analytic_peak(K), rel=1e-4)  # steps of 0.2 ms about the touch


# peaks of y, in metres with five digits, of integrations of the same model by other means
@pytest.mark.parametrize(
    ("target", "K", "peak"),
    [
        (FIGURES, 1.0, -0.34081),
        (FIGURES, 50.0, -0.36760),
        (FIGURES, 1000.0, -0.42863),
        (PRINTED, 1.0, -0.34156),
        (PRINTED, 50.0, -0.38385),
        (PRINTED, 1000.0, -0.43072),
    ],
)
def test_target_model_peaks_where_it_is_known_to(target: list[float], K: float, peak: float) -> None:
    found = predict(
        "model_peak_force",
        target=target,
        surface_stiffness=K,
        surface=-0.44,
        times=[0.0, 1.0],
        positions=[-0.54, -0.34],
    )
    assert found / K - 0.44 == pytest.approx(peak, abs=1.2e-5)  # the printed digit


@pytest.mark.parametrize("K", [25.0, 50.0, 100.0])
def test_target_model_comes_to_rest_as_two_springs(K: float) -> None:
    motion = {"surface_stiffness": K, "surface": -0.34, "times": [0.0, 0.5], "positions": [-0.54, -0.29]}
    found = predict("model_force_at", time=2.99, target=FRAME, **motion)
    rest = predict("spring_force", controller_stiffness=20.0, surface_stiffness=K, depth=0.05)
    assert found == pytest.approx(
        rest, rel=2e-4
    )  # exp(-5 t) after 2.49 s, of a swing of several times the rest


def test_target_model_is_known_from_its_start_to_the_end_of_its_horizon() -> None:
    motion: dict[str, Any] = {"surface": -0.54, "times": [0.0, 0.5], "positions": [-0.53, -0.52]}
    first, last, at_end = (
        predict("model_force_at", time=time, target=FRAME, surface_stiffness=50.0, **motion)
        for time in (0.0, 2.9998, 3.0)
    )
    assert first == pytest.approx(0.5, rel=1e-12)  # 1 cm of 50 N/m, to rounding
    assert at_end == pytest.approx(last, rel=1e-3)  # at rest by then
    for time in (-1e-3, 3.0001, math.nan):
        with pytest.raises(InvalidValueError, match="from 0 to 3"):
            predict("model_force_at", time=time, target=FRAME, surface_stiffness=50.0, **motion)


def test_target_model_feels_nothing_before_it_touches() -> None:
    motion: dict[str, Any] = {"surface": -0.34, "times": [0.0, 1.5, 3.0], "positions": [-0.54, -0.29, -0.44]}
    before, after = (
        predict("model_force_at", time=time, target=FRAME, surface_stiffness=50.0, **motion)
        for time in (1.0, 1.03)
    )
    assert before == 0.0
    assert after > 0.0  # the touch is at 1.01 s


def test_every_formula_says_what_it_is_and_where_it_is_from() -> None:
    assert len(FORMULAS) >= 15
    for name, formula in FORMULAS.items():
        assert formula.name == name
        assert len(formula.text) > 10
        assert formula.source.startswith(("[S]", "[R]"))
