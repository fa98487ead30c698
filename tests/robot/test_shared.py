"""`shared` functions are computed once in the context of `sharing`, and every time outside of it."""

from threading import Thread

import numpy as np
import pytest

from prp_gym.robot.arrays import Array
from prp_gym.robot.shared import shared, sharing

CALLS: list[Array] = []


@shared
def doubled(values: Array, factor: float = 2.0) -> Array:
    CALLS.append(values)
    return factor * values


@pytest.fixture(autouse=True)
def no_calls() -> None:
    CALLS.clear()


def test_it_is_computed_once_in_the_context() -> None:
    values = np.arange(3.0)
    with sharing():
        first, second = doubled(values), doubled(values)
    assert first is second
    assert first.tolist() == [0.0, 2.0, 4.0]
    assert len(CALLS) == 1


def test_it_is_computed_every_time_outside_of_the_context() -> None:
    values = np.arange(3.0)
    with sharing():
        doubled(values)
    values[:] = 1.0
    assert doubled(values).tolist() == [2.0, 2.0, 2.0]
    assert doubled(values) is not doubled(values)
    assert len(CALLS) == 4


def test_other_arguments_have_other_results() -> None:
    """Also arrays that are made anew at an address that was used before, and equal ones."""
    with sharing():
        sums = [float(doubled(np.full(3, float(k))).sum()) for k in range(50)]
        assert sums == [6.0 * k for k in range(50)]
        assert doubled(CALLS[1], 3.0).tolist() == [3.0, 3.0, 3.0]
        assert doubled(CALLS[1], factor=4.0).tolist() == [4.0, 4.0, 4.0]


def test_contexts_within_one_another_and_threads_share_nothing() -> None:
    values = np.arange(3.0)
    with sharing():
        outer = doubled(values)
        with sharing():
            assert doubled(values) is not outer
        thread = Thread(target=doubled, args=(values,))
        thread.start()
        thread.join()
        assert len(CALLS) == 3
        assert doubled(values) is outer


def fail_after_sharing(values: Array) -> None:
    with sharing():
        doubled(values)
        raise KeyError


def test_an_error_ends_the_context() -> None:
    values = np.arange(3.0)
    with pytest.raises(KeyError):
        fail_after_sharing(values)
    doubled(values)
    assert len(CALLS) == 2
