"""The estimate of a surface: recursion against batch least squares, and what must not disturb it."""

import numpy as np
import pytest
from numpy.typing import NDArray

from prp_gym.baselines.base.stiffness_estimator import StiffnessEstimator
from prp_gym.errors import InvalidValueError

Array = NDArray[np.float64]

GUESS = 5000.0
ESTIMATOR = StiffnessEstimator(GUESS, forgetting_time=0.5, period=0.002)


def learn(
    position: Array, force: Array, estimator: StiffnessEstimator = ESTIMATOR, rate: Array | None = None
) -> Array:
    """The memory after measurements (t, ...); the tip moves slowly unless rates are given."""
    memory = estimator.begin(position.shape[1:])
    rates = np.zeros(position.shape) if rate is None else rate
    for p, r, f in zip(position, rates, force, strict=True):
        memory = estimator.update(memory, p, r, f, np.ones(p.shape, dtype=np.bool_))
    return memory


def press(depth: float, count: int) -> Array:
    """Positions (count, 1) of a tip that sinks in at constant speed, 0.4 m from the origin."""
    return 0.4 + np.linspace(0.0, depth, count)[:, None]


@pytest.mark.parametrize("stiffness", [50.0, 700.0, 5000.0])
def test_estimate_is_the_stiffness_once_the_tip_has_moved(stiffness: float) -> None:
    p = press(2.0 / stiffness, 60)
    estimate = ESTIMATOR.stiffness(learn(p, stiffness * (p - 0.39)))
    # the guess weighs as much as a spread of 1e-10 m², the 60 positions at least 2.6e-7 m²
    np.testing.assert_allclose(estimate, stiffness, rtol=2e-3 if stiffness >= 700.0 else 5e-4)


def test_recursion_is_weighted_least_squares() -> None:
    draw = np.random.default_rng(1)
    p = press(0.01, 80)  # always moving: every period forgets
    f = 900.0 * (p - 0.4) + 0.3 * draw.standard_normal(p.shape)
    weights = ESTIMATOR.retention ** np.arange(len(p))[::-1]
    spread, root = ESTIMATOR.guess_spread, np.sqrt(weights)
    # the guess is one more equation, √s K = √s K_0
    rows = np.concatenate([root[:, None] * np.column_stack([p[:, 0], np.ones(len(p))]), [[spread**0.5, 0.0]]])
    values = np.append(root * f[:, 0], spread**0.5 * GUESS)
    expected = np.linalg.lstsq(rows, values, rcond=None)[0][0]
    # moments about the mean against the normal equations of positions near 0.4 m, spread 3 mm
    np.testing.assert_allclose(ESTIMATOR.stiffness(learn(p, f)), expected, rtol=1e-8)


def test_bias_of_the_sensor_does_not_matter() -> None:
    p = press(0.002, 60)
    f = 800.0 * (p - 0.4)
    biased = ESTIMATOR.stiffness(learn(p, f + 0.7))
    # the bias goes into the offset: rounding of forces near 1 N over steps of 30 µm
    np.testing.assert_allclose(biased, ESTIMATOR.stiffness(learn(p, f)), rtol=1e-9)


def test_noise_of_the_sensor_averages_out() -> None:
    draw = np.random.default_rng(2)
    p = np.tile(press(0.004, 60), (1, 500))
    estimates = ESTIMATOR.stiffness(learn(p, 1000.0 * (p - 0.4) + 0.05 * draw.standard_normal(p.shape)))
    # least squares: σ/√S_pp = 0.05/√(60 · 0.004²/12) = 5.6 N/m; forgetting adds a little
    assert abs(estimates.mean() - 1000.0) < 2.0
    assert estimates.std() < 8.0


def test_estimate_is_the_guess_before_the_tip_moves() -> None:
    np.testing.assert_array_equal(ESTIMATOR.stiffness(ESTIMATOR.begin((3,))), GUESS)
    still = np.full((50, 1), 0.4)
    assert ESTIMATOR.stiffness(learn(still, np.full((50, 1), 2.0))) == GUESS


def test_tip_at_rest_forgets_nothing_though_the_sensor_is_noisy() -> None:
    draw = np.random.default_rng(4)
    p = press(0.005, 60)
    f = 600.0 * (p - 0.4)
    rest = np.full((5000, 1), p[-1])  # 10 s, twenty time constants of forgetting
    noisy = f[-1] + 0.05 * draw.standard_normal(rest.shape)
    estimate = ESTIMATOR.stiffness(learn(np.concatenate([p, rest]), np.concatenate([f, noisy])))
    # the mean of the noise at rest, below 0.002 N, moves the fit by as much over half the depth
    np.testing.assert_allclose(estimate, 600.0, rtol=2e-3)


def test_moving_tip_forgets_an_earlier_stiffness() -> None:
    down = press(0.01, 250)
    soft = 200.0 * (down - 0.4)
    further = down[-1] + np.linspace(0.0, 0.05, 1250)[1:, None]
    hard = soft[-1] + 1500.0 * (further - down[-1])
    p, f = np.concatenate([down, further]), np.concatenate([soft, hard])
    faithful = StiffnessEstimator(GUESS, forgetting_time=1e6, period=0.002)
    # five time constants later
    np.testing.assert_allclose(ESTIMATOR.stiffness(learn(p, f)), 1500.0, rtol=0.02)
    assert faithful.stiffness(learn(p, f, faithful)) < 1450.0


def test_damping_is_estimated_beside_the_stiffness() -> None:
    time = 0.002 * np.arange(150)[:, None]
    p = 0.4 + 0.004 * (1.0 - np.cos(8.0 * time))
    rate = 0.004 * 8.0 * np.sin(8.0 * time)
    memory = learn(p, 60.0 * (p - 0.4) + 9.0 * rate + 0.2, rate=rate)
    estimate = ESTIMATOR.surface(memory)
    # no damping counts as much as a spread of 2.5e-5 m²/s², the 250 rates that count have 5e-3 to 2e-2
    np.testing.assert_allclose(estimate.stiffness, 60.0, rtol=1e-2)
    np.testing.assert_allclose(estimate.damping, 9.0, rtol=1e-2)


def test_both_estimates_are_regularised_least_squares() -> None:
    draw = np.random.default_rng(8)
    p, rate = 0.4 + 0.003 * draw.standard_normal((90, 1)), 0.05 * draw.standard_normal((90, 1))
    f = 300.0 * (p - 0.4) + 5.0 * rate + 0.3 * draw.standard_normal(p.shape)
    faithful = StiffnessEstimator(GUESS, forgetting_time=1e9, period=0.002)
    priors = np.sqrt([[faithful.guess_spread, 0.0], [0.0, faithful.damping_spread]])
    rows = np.block([[np.column_stack([p, rate]), np.ones((90, 1))], [priors, np.zeros((2, 1))]])
    values = np.concatenate([f[:, 0], [priors[0, 0] * GUESS, 0.0]])
    stiffness, damping, _ = np.linalg.lstsq(rows, values, rcond=None)[0]
    estimate = faithful.surface(learn(p, f, faithful, rate))
    # normal equations against a QR factorisation; 90 weights lose 1e-11 of themselves
    np.testing.assert_allclose(estimate.stiffness, stiffness, rtol=1e-7)
    np.testing.assert_allclose(estimate.damping, damping, rtol=1e-7)


def test_surface_without_damping_gets_none() -> None:
    p = press(0.004, 60)
    estimate = ESTIMATOR.surface(learn(p, 400.0 * (p - 0.4), rate=np.full(p.shape, 0.03)))
    np.testing.assert_array_equal(estimate.damping, 0.0)


def test_lost_contact_leaves_the_memory_of_that_one_as_it_was() -> None:
    p = np.tile(press(0.005, 60), (1, 2))
    memory = learn(p, 300.0 * (p - 0.4))
    after = ESTIMATOR.update(memory, p[-1], np.zeros(2), np.zeros(2), np.array([True, False]))
    np.testing.assert_array_equal(after[1], memory[1])
    assert not np.array_equal(after[0], memory[0])


def test_estimate_stays_within_its_range() -> None:
    p = press(0.01, 60)
    slopes = np.array([-500.0, 0.0, 1e6])
    estimate = ESTIMATOR.stiffness(learn(np.tile(p, (1, 3)), slopes * (p - 0.4)))
    np.testing.assert_array_equal(estimate, [1.0, 1.0, 2e4])


@pytest.mark.parametrize("name", ["initial_stiffness", "forgetting_time", "period"])
def test_number_that_is_not_positive_is_refused(name: str) -> None:
    numbers = {"initial_stiffness": 1.0, "forgetting_time": 1.0, "period": 1.0, name: 0.0}
    with pytest.raises(InvalidValueError, match=name):
        StiffnessEstimator(**numbers)


def test_deviation_is_the_spread_of_estimates_over_noise() -> None:
    draws, samples = 4000, 12
    p = np.tile(0.4 + 0.00004 * np.arange(samples)[:, None], draws)
    noise = ESTIMATOR.force_noise * np.random.default_rng(3).standard_normal(p.shape)
    # a slow touch: damping has no part in it, and the estimate stays within its bounds
    estimate = ESTIMATOR.surface(learn(p, 9000.0 * (p - 0.4) + noise, rate=np.zeros(p.shape)))
    assert ESTIMATOR.allowed[0] < estimate.stiffness.min() < estimate.stiffness.max() < ESTIMATOR.allowed[1]
    # the guess pulls the mean by 4 %; 4000 draws give their deviation within 4 %, three times 1/sqrt(8000);
    # forgetting makes the samples' weights unequal, by 2 % from first to last
    np.testing.assert_allclose(estimate.stiffness.std(), estimate.deviation[0], rtol=0.05)
    np.testing.assert_allclose(estimate.upper_stiffness, estimate.stiffness + 8.0 * estimate.deviation)


def test_upper_bound_is_no_more_than_a_surface_can_have_nor_less_than_the_estimate() -> None:
    p = press(0.00004, 3)
    memory = learn(p, 300.0 * (p - 0.4))
    for greatest in (1.0, 400.0, 1e4):
        estimate = StiffnessEstimator(GUESS, 0.5, 0.002, greatest).surface(memory)
        expected = max(
            estimate.stiffness[0], min(estimate.stiffness[0] + 8.0 * estimate.deviation[0], greatest)
        )
        assert estimate.upper_stiffness[0] == expected
