"""Interquartile means and their bootstrap intervals."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from prp_gym.errors import InvalidValueError
from prp_gym.evaluation import Estimate, bootstrap_interquartile_mean, interquartile_mean

PROPERTY = settings(max_examples=50, deadline=None, derandomize=True)
SCORES = st.lists(st.floats(0.0, 1.0), min_size=1, max_size=24)
ROUNDING = 1e-12  # sums of up to 24 numbers up to 1


def by_hand(values: list[float]) -> float:
    """The mean of what is left when a quarter of the numbers, rounded down, is struck off at each end."""
    left = list(values)
    for _ in range(len(values) // 4):
        left.remove(min(left))
        left.remove(max(left))
    return sum(left) / len(left)


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ([5.0], 5.0),
        ([1.0, 4.0], 2.5),
        ([0.0, 3.0, 9.0], 4.0),  # three: nothing to strike off
        ([100.0, 2.0, -50.0, 4.0], 3.0),
        ([8.0, 1.0, 2.0, 3.0, -9.0], 2.0),
        ([1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 1e9], 4.5),
    ],
)
def test_interquartile_mean_of_known_numbers(values: list[float], expected: float) -> None:
    assert interquartile_mean(np.array(values)) == pytest.approx(expected, rel=1e-15)


@PROPERTY
@given(values=SCORES)
def test_interquartile_mean_strikes_off_a_quarter_at_each_end(values: list[float]) -> None:
    assert interquartile_mean(np.array(values)) == pytest.approx(by_hand(values), abs=ROUNDING)


@PROPERTY
@given(values=SCORES, shift=st.floats(-10.0, 10.0), scale=st.floats(0.1, 10.0), seed=st.integers(0, 99))
def test_interquartile_mean_moves_with_its_numbers_and_not_with_their_order(
    values: list[float], shift: float, scale: float, seed: int
) -> None:
    array = np.array(values)
    shuffled = np.random.default_rng(seed).permutation(array)
    expected = shift + scale * float(interquartile_mean(array))
    assert interquartile_mean(shift + scale * shuffled) == pytest.approx(expected, abs=20 * ROUNDING)


def test_interquartile_mean_works_along_the_last_axis_and_leaves_its_argument() -> None:
    values = np.random.default_rng(0).normal(size=(2, 3, 9))
    values.flags.writeable = False
    result = interquartile_mean(values)
    assert result.shape == (2, 3)
    for index in np.ndindex(2, 3):
        assert result[index] == pytest.approx(by_hand(values[index].tolist()), abs=ROUNDING)


@PROPERTY
@given(values=SCORES, seed=st.integers(0, 99))
def test_interval_contains_the_estimate_within_the_range_of_the_numbers(
    values: list[float], seed: int
) -> None:
    rng = np.random.default_rng(seed)
    estimate = bootstrap_interquartile_mean(np.array(values), rng, resamples=500)
    assert min(values) - ROUNDING <= estimate.low <= estimate.value + ROUNDING
    assert estimate.value - ROUNDING <= estimate.high <= max(values) + ROUNDING
    assert estimate.value == pytest.approx(by_hand(values), abs=ROUNDING)


@pytest.mark.parametrize("values", [[0.3], [0.1] * 3, [0.7] * 20])
def test_interval_without_spread_is_the_point(values: list[float]) -> None:
    estimate = bootstrap_interquartile_mean(np.array(values), np.random.default_rng(0))
    # a mean of equal numbers is rounded in the same way in every resample
    assert estimate == Estimate(estimate.value, estimate.value, estimate.value)
    assert estimate.value == pytest.approx(values[0], rel=1e-15)


def test_interval_depends_on_the_generator_alone() -> None:
    values = np.random.default_rng(5).uniform(size=12)
    first, again, other = (
        bootstrap_interquartile_mean(values, np.random.default_rng(seed), resamples=200) for seed in (1, 1, 2)
    )
    assert first == again
    assert first.value == other.value
    assert (first.low, first.high) != (other.low, other.high)


def test_interval_widens_with_confidence() -> None:
    values = np.random.default_rng(6).normal(size=16)
    widths = []
    for confidence in (0.5, 0.9, 0.99):
        estimate = bootstrap_interquartile_mean(values, np.random.default_rng(7), confidence)
        widths.append(estimate.high - estimate.low)
    assert widths == sorted(set(widths))


def test_interval_cuts_the_same_share_off_both_ends() -> None:
    # two numbers: a resample is (0, 0), (0, 1), (1, 0) or (1, 1), so the mean is 0, ½ or 1 with ¼, ½, ¼
    values = np.array([0.0, 1.0])
    wide = bootstrap_interquartile_mean(values, np.random.default_rng(8), confidence=0.6)
    narrow = bootstrap_interquartile_mean(values, np.random.default_rng(8), confidence=0.4)
    assert wide == Estimate(0.5, 0.0, 1.0)
    assert narrow == Estimate(0.5, 0.5, 0.5)


def test_interval_covers_the_true_value_about_as_often_as_it_says() -> None:
    rng = np.random.default_rng(9)
    samples = rng.normal(loc=0.4, size=(400, 40))
    intervals = [bootstrap_interquartile_mean(row, rng, 0.9, resamples=200) for row in samples]
    coverage = np.mean([estimate.low <= 0.4 <= estimate.high for estimate in intervals])
    # percentile intervals of 40 numbers are a few percent too narrow; 400 trials have a deviation of 1.5 %
    assert 0.82 < coverage < 0.95


def test_no_values_are_refused() -> None:
    with pytest.raises(InvalidValueError, match="number of values is 0; allowed: at least 1"):
        bootstrap_interquartile_mean(np.array([]), np.random.default_rng(0))


@pytest.mark.parametrize("confidence", [0.0, 1.0, -0.1, 95.0, float("nan")])
def test_confidence_outside_its_range_is_refused(confidence: float) -> None:
    with pytest.raises(InvalidValueError, match=r"confidence is .*; allowed: between 0 and 1"):
        bootstrap_interquartile_mean(np.ones(3), np.random.default_rng(0), confidence)
