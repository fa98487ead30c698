"""Taring of the force sensor: the mean of the readings off the surface, and what must not be subtracted."""

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from prp_gym.baselines.base.force_sensing import ForceSensingSettings
from prp_gym.baselines.base.taring import Taring, TaringUntilContact, TaringWheneverFree
from tests.support.contact_cases import controller, random_observation

Array = NDArray[np.float64]

NOISE, BIAS = 0.05, np.array([0.08, -0.06, 0.09])
UNTIL = TaringUntilContact(NOISE, 0.4)
WHENEVER = TaringWheneverFree(NOISE, 0.4, math.inf, least_stiffness=50.0)
INTO = np.array([0.0, 1.0, 0.0])


def noise(count: int, seed: int = 1) -> Array:
    return NOISE * np.random.default_rng(seed).standard_normal((count, 3))


def corrected(taring: Taring, readings: Array, tip: Array | None = None) -> Array:
    """The corrected forces for readings (t, ..., 3), with the tip at rest unless positions are given."""
    memory = taring.begin(readings.shape[1:-1])
    tips = np.zeros(readings.shape) if tip is None else tip
    forces = []
    for reading, position in zip(readings, tips, strict=True):
        force, memory = taring.step(memory, reading, position)
        forces.append(force)
    return np.array(forces)


@pytest.mark.parametrize("taring", [UNTIL, WHENEVER])
def test_mean_before_the_touch_is_subtracted_from_all_that_follows(taring: Taring) -> None:
    free, pressed = BIAS + noise(200), BIAS + noise(300, 2) + 4.0 * INTO
    forces = corrected(taring, np.concatenate([free, pressed]))
    # 15 to 30 of the 200 readings are dropped, and one to two more may still wait for s = 0; in the period of
    # the touch itself they are not dropped yet
    tares = [free[:count].mean(axis=0) for count in range(168, 186)]
    tare = (pressed - forces[200:])[1:]
    np.testing.assert_allclose(tare, np.broadcast_to(tare[0], tare.shape), atol=1e-12)
    assert min(np.abs(tare[0] - own).max() for own in tares) < 1e-12


def test_noise_alone_is_no_touch() -> None:
    readings = BIAS + noise(2500 * 40, 3).reshape(2500, 40, 3)
    forces = corrected(UNTIL, readings)
    # a tare that stood still after a false touch would differ from the mean of all readings
    np.testing.assert_allclose(readings[-1] - forces[-1], readings.mean(axis=0), atol=0.002)


@pytest.mark.parametrize(("stiffness", "speed"), [(5.0, 0.25), (50.0, 0.25), (50.0, 0.02), (5000.0, 0.02)])
def test_force_that_grows_slowly_is_hardly_subtracted(stiffness: float, speed: float) -> None:
    depth = np.maximum(0.0, speed * (0.002 * np.arange(1500)[:, None] - 0.4))  # a touch after 200 periods
    force = np.minimum(stiffness * depth, 1.0) * INTO
    last = np.mean(
        [corrected(UNTIL, BIAS + noise(1500, seed) + force)[-300:] for seed in range(4)], axis=(0, 1)
    )
    # a force below 2.8 σ = 0.14 N is not seen: it is averaged while it grows, and weighs against 200
    # readings, but for the last 15, which are dropped
    waiting = max(0.0, 0.14 / (stiffness * speed * 0.002) - 15.0)
    allowed = 0.01 + 0.14 / 2.0 * waiting / (waiting + 200.0)
    np.testing.assert_allclose(last, force[-1], atol=allowed)


def test_first_reading_above_the_largest_bias_is_a_contact() -> None:
    readings = 2.0 * INTO + noise(50)
    np.testing.assert_array_equal(corrected(UNTIL, readings), readings)


def test_sensor_is_tared_again_once_the_tip_has_left_the_surface() -> None:
    free, drifted = BIAS + noise(100), BIAS + 0.15 + noise(400, 5)
    readings = np.concatenate([free, BIAS + 3.0 * INTO + noise(100, 4), drifted])
    depth = np.concatenate([np.zeros(100), np.full(100, 0.02), np.full(400, -0.01)])
    tip = depth[:, None] * INTO
    forces = corrected(WHENEVER, readings, tip)
    np.testing.assert_allclose(forces[-1], drifted[-1] - drifted.mean(axis=0), atol=0.002)
    once = corrected(UNTIL, readings, tip)
    np.testing.assert_allclose(once[-1], drifted[-1] - free.mean(axis=0), atol=0.01)


def test_small_force_in_contact_is_not_tared_away() -> None:
    """0.1 N on the softest surface, 50 N/m, after a touch: the tip never leaves by the clearance, 6.8 mm."""
    pressed, eased = np.arange(0.0, 0.04, 0.0005), np.full(2000, 0.002)  # at 0.25 m/s, then nearly back
    depth = np.concatenate([pressed, eased])[:, None] * INTO
    readings = np.concatenate([noise(100), 50.0 * depth + noise(len(depth), 7)])
    tip = np.concatenate([np.zeros((100, 3)), depth])
    forces = corrected(WHENEVER, readings, tip)
    # the tare is the mean of 100 readings: 0.005 N on each axis, four times that
    np.testing.assert_allclose(forces[-2000:].mean(axis=0), 0.1 * INTO, atol=0.02)


def test_tip_that_slides_along_the_surface_after_a_faint_touch_has_not_left_it() -> None:
    """The force of the touch, 0.15 N, has noise of 0.05 N on every axis: its direction says little."""
    along = np.array([0.0, 0.0, 1.0])
    for seed in range(40):
        readings = np.concatenate([noise(200, seed), 0.3 * INTO + noise(800, 100 + seed)])
        slide = np.concatenate([np.zeros(200), np.linspace(0.0, 0.04, 800)])[:, None] * along
        for sign in (1.0, -1.0):
            forces = corrected(WHENEVER, readings, sign * slide)
            np.testing.assert_allclose(forces[-400:].mean(axis=0), 0.3 * INTO, atol=0.03)


def test_first_reading_that_is_far_off_is_no_lasting_touch() -> None:
    """One of 4 σ, in which all later ones differ from it by as much."""
    readings = BIAS + noise(300, 9)
    readings[0] = BIAS - 4.0 * NOISE * INTO
    forces = corrected(WHENEVER, readings)
    np.testing.assert_allclose(forces[-100:].mean(axis=0), 0.0, atol=0.02)


@pytest.mark.parametrize("after", [1, 5, 30])
def test_force_is_seen_after_few_readings_too(after: int) -> None:
    readings = np.concatenate([BIAS + noise(after, 3), BIAS + 1.0 * INTO + noise(300, 4)])
    forces = corrected(UNTIL, readings)
    # the tare of one reading has its noise: 3 σ
    np.testing.assert_allclose(forces[-1], INTO, atol=6.0 * NOISE)


def test_rows_of_a_batch_are_independent() -> None:
    free = BIAS + noise(300, 8).reshape(100, 3, 3)
    free[50:, 1] += 3.0 * INTO
    tip = np.zeros(free.shape)
    tip[60:, 1] = -0.02 * INTO
    together = corrected(WHENEVER, free, tip)
    for row in range(3):
        np.testing.assert_array_equal(together[:, row], corrected(WHENEVER, free[:, row], tip[:, row]))


@pytest.mark.parametrize(
    "name", ["impedance", "admittance", "force_inner_position", "parallel_force_position"]
)
def test_untared_controllers_keep_no_readings(name: str) -> None:
    observed = random_observation(3, 2)
    tared, untared = controller(name, "tuned"), controller(name, "report")
    assert len(tared.initial_state(observed)) > len(untared.initial_state(observed))
    assert ForceSensingSettings().taring == "none"
    assert untared.settings.taring == "none"
