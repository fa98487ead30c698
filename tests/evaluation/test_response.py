"""What is said about any response to a reference, on made-up motions."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from prp_gym.evaluation import response as m
from tests.support.synthetic_episodes import (
    GOAL,
    ROUNDING,
    SAMPLES,
    TIME,
    Array,
    assert_batch_equals_loop,
    jump,
    random_motions,
    reference,
)


def test_root_mean_square_and_maximum_error_of_known_errors() -> None:
    error = np.zeros((SAMPLES, 3))
    error[:, 0] = 0.3
    error[:, 1] = 0.2 * (-1.0) ** np.arange(SAMPLES)
    error[7, 2] = -5.05
    actual = reference() - error
    expected = [0.3, 0.2, 5.05 / np.sqrt(SAMPLES)]
    np.testing.assert_allclose(m.root_mean_square_error(actual, reference()), expected, rtol=ROUNDING)
    np.testing.assert_allclose(m.maximum_error(actual, reference()), [0.3, 0.2, 5.05], rtol=ROUNDING)


def test_distances_are_norms_of_the_error() -> None:
    error = np.zeros((SAMPLES, 3))
    error[:, :2] = [0.3, -0.4]
    error[7] = [1.0, 2.0, -2.0]
    actual = reference() - error
    np.testing.assert_allclose(m.distance(actual, reference())[[6, 7]], [0.5, 3.0], rtol=ROUNDING)
    assert m.maximum_distance(actual, reference()) == pytest.approx(3.0, rel=ROUNDING)
    mean = np.sqrt((0.25 * (SAMPLES - 1) + 9.0) / SAMPLES)
    assert m.root_mean_square_distance(actual, reference()) == pytest.approx(mean, rel=ROUNDING)


@pytest.mark.parametrize(
    ("outside", "index"), [((), 0), ((0,), 1), ((0, 1, 40), 41), ((SAMPLES - 2,), SAMPLES - 1)]
)
def test_time_inside_for_good_is_that_of_the_sample_after_the_last_outside(
    outside: tuple[int, ...], index: int
) -> None:
    flags = np.isin(np.arange(SAMPLES), outside)
    assert m.time_inside_for_good(TIME, flags) == TIME[index]


def test_time_inside_for_good_is_infinite_if_the_last_sample_is_outside() -> None:
    assert m.time_inside_for_good(TIME, np.arange(SAMPLES) == SAMPLES - 1) == np.inf


def test_steady_state_error_is_the_signed_mean_over_the_last_tenth() -> None:
    actual = jump(50)
    actual[-10:] = GOAL - np.array([0.01, -0.002, 0.03])
    actual[-10::2, 0] += 0.005
    actual[-11] = 7.0  # before the last tenth of 101 samples
    expected = [0.0075, -0.002, 0.03]
    np.testing.assert_allclose(m.steady_state_error(actual, reference()), expected, atol=ROUNDING)


def test_steady_state_error_of_a_short_episode_is_that_of_its_last_sample() -> None:
    actual = np.array([[0.0, 0.0, 0.0], [0.9, -0.1, 1.5]])
    expected = GOAL - actual[-1]
    np.testing.assert_allclose(m.steady_state_error(actual, reference()[:2]), expected, rtol=ROUNDING)


def test_steady_state_error_needs_a_reference_that_rests_at_the_end_only() -> None:
    early, late = reference(), reference()
    early[30, 1] += 0.1
    late[-3, 1] += 0.1
    np.testing.assert_array_equal(m.steady_state_error(jump(50), early), 0.0)
    assert np.isnan(m.steady_state_error(jump(50), late)).all()


BATCHED: dict[str, Callable[[Array, Array], NDArray[Any]]] = {
    "root_mean_square": lambda actual, desired: m.root_mean_square(actual),
    "root_mean_square_error": m.root_mean_square_error,
    "maximum_error": m.maximum_error,
    "distance": m.distance,
    "root_mean_square_distance": m.root_mean_square_distance,
    "maximum_distance": m.maximum_distance,
    "is_constant": lambda actual, desired: m.is_constant(desired),
    "time_inside_for_good": lambda actual, desired: m.time_inside_for_good(TIME, actual[..., 0] > 0.5),
    "steady_state_error": m.steady_state_error,
}


@pytest.mark.parametrize("name", BATCHED)
def test_batch_equals_a_loop_over_single_episodes(name: str) -> None:
    actual, desired = random_motions(1, 2, 4)
    desired[0, 1, 50:] += 0.1  # a moving reference among constant ones
    desired[0, 2, -1] += 0.1  # and one that moves at the end
    assert_batch_equals_loop(BATCHED[name], actual, desired)
