"""Metrics of the contact on made-up forces whose values are known beforehand."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from prp_gym.evaluation import episode_metrics
from prp_gym.evaluation.metrics import force as m
from prp_gym.tasks.settling.directions import along_desired
from tests.support.synthetic_episodes import (
    PERIOD,
    ROUNDING,
    SAMPLES,
    TIME,
    Array,
    assert_batch_equals_loop,
    make_rollout,
)

INTO = np.array([0.6, -0.8, 0.0])
ACROSS = np.array([0.8, 0.6, 0.0])
WANTED = 5.0  # [N], so that the band is 0.1 N
DESIRED = np.tile(WANTED * INTO, (SAMPLES, 1))


def press(touch: int, *later: tuple[int, float], force: float = WANTED) -> Array:
    """No contact before a sample, then a force [N] into the surface, another one from each later sample."""
    size = np.zeros(SAMPLES)
    for sample, value in ((touch, force), *later):
        size[sample:] = value
    pressing: Array = size[:, None] * INTO
    return pressing


def force_values(force: Array, desired: Array = DESIRED) -> dict[str, float]:
    values = episode_metrics(make_rollout({"contact_force": force, "desired_force": desired}))
    return {name: float(numbers[0]) for name, numbers in values.items()}


@pytest.mark.parametrize(("force", "settles"), [(4.91, True), (5.09, True), (4.89, False), (5.11, False)])
def test_force_settles_within_two_percent_of_the_desired_one_on_both_sides(
    force: float, settles: bool
) -> None:
    time = m.force_settling_time(TIME, press(20, (50, force), force=1.0), DESIRED)
    assert time == pytest.approx(0.3 if settles else np.inf, abs=ROUNDING)


def test_force_settles_after_the_first_touch_and_not_after_the_last() -> None:
    bouncing = press(20, (30, 0.0), (40, WANTED))
    assert m.force_settling_time(TIME, bouncing, DESIRED) == pytest.approx(0.2, abs=ROUNDING)
    assert m.contact_losses(bouncing) == 1.0


def test_force_that_is_there_from_the_start_has_settled_at_once() -> None:
    assert m.force_settling_time(TIME, DESIRED, DESIRED) == 0.0
    assert m.force_settling_time(TIME, press(1), DESIRED) == pytest.approx(0.0, abs=ROUNDING)


def test_deviation_counts_across_the_desired_force_alone() -> None:
    force = np.tile([0.0, -2.0, 0.0], (4, 1))
    desired = np.zeros((4, 3))
    actual = np.array([[0.0, 5.0, 0.0], [3.0, -7.0, 4.0], [0.0, 0.0, -1.0], [2.0, 1.0, 0.0]])
    assert m.mean_deviation_across(actual, desired, force) == pytest.approx((0.0 + 5.0 + 1.0 + 2.0) / 4)
    tilted = np.tile([3.0, 4.0, 0.0], (4, 1))  # along (0.6, 0.8, 0); across it is (0.8, -0.6, 0)
    slid = np.tile([0.08, -0.06, 0.0], (4, 1)) + np.outer([1.0, 2.0, 3.0, 4.0], [0.6, 0.8, 0.0])
    assert m.mean_deviation_across(slid, desired, tilted) == pytest.approx(0.1)
    assert np.isnan(m.mean_deviation_across(actual, desired, 0.0 * force))


def test_force_along_the_desired_one_is_what_counts() -> None:
    rubbing = press(20) + 3.0 * ACROSS  # friction that nobody asked for or against
    values = force_values(rubbing)
    still = force_values(press(20))
    for name in ("force_rmse", "steady_state_force_error", "force_overshoot"):
        assert values[name] == pytest.approx(still[name], abs=1e-10)
    assert values["force_rmse"] == pytest.approx(WANTED * np.sqrt(20 / SAMPLES), rel=1e-10)
    assert values["peak_force"] == pytest.approx(np.sqrt(34.0), rel=1e-10)


def test_steady_force_error_is_signed_and_that_of_the_last_tenth() -> None:
    weak, strong = press(20, (91, 4.5)), press(20, (91, 5.5))
    weak[90] = 70.0  # before the last tenth of 101 samples
    assert force_values(weak)["steady_state_force_error"] == pytest.approx(0.5, rel=1e-10)
    assert force_values(strong)["steady_state_force_error"] == pytest.approx(-0.5, rel=1e-10)


def test_force_overshoot_is_the_excess_over_the_desired_force() -> None:
    assert m.force_overshoot(press(20, (30, 6.0), (31, 5.0)), DESIRED) == pytest.approx(20.0, rel=1e-10)
    assert m.force_overshoot(press(20, force=4.9), DESIRED) == 0.0


def test_pulling_is_an_error_and_no_overshoot() -> None:
    values = force_values(-press(0))
    assert values["force_rmse"] == pytest.approx(2.0 * WANTED, rel=1e-10)
    assert values["force_overshoot"] == 0.0


def test_episode_without_contact_never_settles_and_peaks_at_nothing() -> None:
    values = force_values(np.zeros((SAMPLES, 3)))
    assert values["force_settling_time"] == np.inf
    assert values["force_rmse"] == pytest.approx(WANTED, rel=ROUNDING)
    assert values["steady_state_force_error"] == pytest.approx(WANTED, rel=ROUNDING)
    for name in ("force_overshoot", "peak_force", "contact_losses"):
        assert values[name] == 0.0


def test_changing_desired_force_is_no_step() -> None:
    changing = DESIRED.copy()
    changing[30] *= 1.0 + 1e-9
    values = force_values(press(20), changing)
    assert np.isnan(values["force_settling_time"])
    assert np.isnan(values["force_overshoot"])
    assert values["steady_state_force_error"] == pytest.approx(0.0, abs=1e-10)
    changing[-1] *= 2.0
    assert np.isnan(force_values(press(20), changing)["steady_state_force_error"])


def test_force_error_has_no_direction_where_no_force_is_desired() -> None:
    values = force_values(press(20), np.zeros((SAMPLES, 3)))
    for name in ("force_rmse", "steady_state_force_error", "force_settling_time", "force_overshoot"):
        assert np.isnan(values[name])
    assert values["peak_force"] == pytest.approx(WANTED, rel=ROUNDING)


@pytest.mark.parametrize(
    ("force", "losses"),
    [
        (press(20), 0.0),
        (DESIRED, 0.0),
        (press(0, (10, 0.0)), 1.0),
        (press(20, (30, 0.0), (40, 1.0), (50, 0.0), (51, 2.0)), 2.0),
        (press(20, (30, 0.0), (40, 1.0), (SAMPLES - 1, 0.0)), 2.0),
        (press(20, (30, 1.1e-6), (40, 1.0)), 0.0),
        (press(20, (30, 0.9e-6), (40, 1.0)), 1.0),
        (press(20, (30, -1.0)), 0.0),
    ],
)
def test_contact_is_lost_each_time_that_the_force_vanishes(force: Array, losses: float) -> None:
    assert m.contact_losses(force) == losses


def test_force_violation_is_the_share_of_steps_beyond_the_bound() -> None:
    bound = np.array([0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0])
    episode = make_rollout({"any": np.zeros((9, 1))}, info={"cost_force_bound": bound})
    np.testing.assert_allclose(episode_metrics(episode)["force_violation"], [37.5], rtol=ROUNDING)


MASS, STIFFNESS, AMPLITUDE, FREQUENCY = 0.5, 50.0, 0.02, 4.0 * np.pi  # two periods in the second


def impedance(damping: float) -> tuple[Array, Array]:
    """Force and error's rate of M x̃¨ + K_D x̃˙ + K_P x̃ = h_e on x̃ = A (1 - cos ωt), at rest at first."""
    phase = FREQUENCY * TIME
    error, rate = AMPLITUDE * (1.0 - np.cos(phase)), AMPLITUDE * FREQUENCY * np.sin(phase)
    force = MASS * AMPLITUDE * FREQUENCY**2 * np.cos(phase) + damping * rate + STIFFNESS * error
    return force[:, None] * INTO, rate[:, None] * INTO


@pytest.mark.parametrize("reference_speed", [-0.3, 0.0, 0.3])
def test_impedance_with_damping_that_starts_at_rest_injects_nothing(reference_speed: float) -> None:
    force, rate = impedance(damping=10.0)
    desired = np.tile(reference_speed * INTO, (SAMPLES, 1))
    assert m.injected_energy(force, desired, desired - rate, PERIOD) == 0.0


def test_impedance_with_negative_damping_injects_what_the_damper_gives() -> None:
    force, rate = impedance(damping=-10.0)
    # ∫ 10 x̃˙² dt over whole periods; the rule is exact for products of sines over them
    expected = 10.0 * (AMPLITUDE * FREQUENCY) ** 2 / 2
    measured = m.injected_energy(force, np.zeros((SAMPLES, 3)), -rate, PERIOD)
    assert measured == pytest.approx(expected, rel=1e-10)


def test_spring_that_starts_stretched_returns_what_it_held() -> None:
    error = AMPLITUDE * (1.0 - TIME)  # relaxes at constant speed, so that the rule is exact
    force = STIFFNESS * error[:, None] * INTO
    velocity = np.tile(AMPLITUDE * INTO, (SAMPLES, 1))
    measured = m.injected_energy(force, np.zeros((SAMPLES, 3)), velocity, PERIOD)
    assert measured == pytest.approx(STIFFNESS * AMPLITUDE**2 / 2, rel=1e-10)


def test_energy_that_was_received_first_may_be_given_back() -> None:
    force = np.tile(2.0 * INTO, (SAMPLES, 1))
    speed = np.where(TIME < 0.495, -0.1, 0.1)  # 49 intervals in, one of change, 50 out
    velocity = speed[:, None] * INTO
    rest = np.zeros((SAMPLES, 3))
    assert m.injected_energy(force, rest, velocity, PERIOD) == pytest.approx(0.2 * PERIOD, rel=1e-10)
    assert m.injected_energy(force, rest, -velocity, PERIOD) == pytest.approx(49 * 0.2 * PERIOD, rel=1e-10)


def test_free_motion_injects_nothing_and_angles_do_not_matter() -> None:
    turning = np.tile([0.0, 0.0, 0.0, 1.0, 1.0, 1.0], (SAMPLES, 1))
    rest = np.zeros((SAMPLES, 6))
    fields = {"desired_velocity": rest, "end_effector_velocity": turning, "model_pose": rest}
    for force in (np.zeros((SAMPLES, 3)), press(20)):
        values = episode_metrics(make_rollout({**fields, "contact_force": force}))
        np.testing.assert_array_equal(values["injected_energy"], [0.0])


BATCHED: dict[str, Callable[[Array, Array], NDArray[Any]]] = {
    "in_contact": lambda force, desired: m.in_contact(force),
    "along_desired": lambda force, desired: np.concatenate(along_desired(force, desired), axis=-1),
    "force_settling_time": lambda force, desired: m.force_settling_time(TIME, force, desired),
    "force_overshoot": m.force_overshoot,
    "peak_force": lambda force, desired: m.peak_force(force),
    "contact_losses": lambda force, desired: m.contact_losses(force),
    "injected_energy": lambda force, desired: m.injected_energy(force, desired, force[..., ::-1], PERIOD),
}


@pytest.mark.parametrize("name", BATCHED)
def test_batch_equals_a_loop_over_single_episodes(name: str) -> None:
    rng = np.random.default_rng(2)
    force = np.maximum(rng.normal(1.0, 1.0, size=(2, 4, SAMPLES, 1)), 0.0) * INTO
    desired = np.broadcast_to(rng.uniform(1.0, 2.0, size=(2, 4, 1, 1)) * INTO, force.shape).copy()
    force[0, :2, 60:] = desired[0, :2, 60:]  # settled ones
    force[1, 0] = 0.0  # one without contact
    desired[1, 1, 50:] *= 1.1  # a changing one
    desired[1, 2] = 0.0  # and one that is not wanted
    assert_batch_equals_loop(BATCHED[name], force, desired)
