"""The reference window: its values are those of the reference at each environment's own time."""

import numpy as np
import pytest
from numpy.typing import NDArray

from prp_gym.envs.core.reference_window import ReferenceWindow
from prp_gym.robot.arrays import Array

PERIOD = 0.002


class Recorder:
    """A sampler whose rows are (time, id), and which counts its calls."""

    def __init__(self) -> None:
        self.calls = 0

    def __call__(self, time: Array, ids: NDArray[np.intp] | None) -> Array:
        self.calls += 1
        if ids is None:
            ids = np.arange(time.shape[1])
        assert time.shape[1:] == ids.shape
        return np.stack([time, np.broadcast_to(ids, time.shape)], axis=-1)


def begun(num_envs: int) -> tuple[ReferenceWindow, Recorder]:
    window, sampler = ReferenceWindow(num_envs, PERIOD), Recorder()
    window.begin(np.arange(num_envs), sampler)
    return window, sampler


def assert_current(window: ReferenceWindow, steps: list[int]) -> None:
    """Every environment is at its own number of steps, to the last bit."""
    expected = np.stack([np.array(steps) * PERIOD, np.arange(len(steps))], axis=-1)
    np.testing.assert_array_equal(window.current, expected)


@pytest.mark.parametrize("num_envs", [1, 3, 2000, 40_000])
def test_every_step_is_looked_up_correctly_across_refills(num_envs: int) -> None:
    window, sampler = begun(num_envs)
    assert_current(window, [0] * num_envs)
    for step in range(1, 1100 if num_envs < 10 else 80):
        window.advance(sampler)
        assert_current(window, [step] * num_envs)
    assert sampler.calls > 2


def test_references_are_computed_far_less_often_than_looked_up() -> None:
    window, sampler = begun(2)
    for _ in range(2500):
        window.advance(sampler)
    assert sampler.calls == 6  # at the start, one step later, then every 512 steps


@pytest.mark.parametrize("moment", [1, 511, 512, 700])
def test_restarted_environments_begin_at_zero_and_the_others_go_on(moment: int) -> None:
    window, sampler = begun(3)
    for _ in range(moment):
        window.advance(sampler)
    window.begin(np.array([2, 0]), sampler)
    assert_current(window, [0, moment, 0])
    for step in range(1, 1100):
        window.advance(sampler)
        assert_current(window, [step, moment + step, step])


def test_environments_may_restart_at_different_times() -> None:
    window, sampler = begun(3)
    for restarted in range(3):
        for _ in range(200):
            window.advance(sampler)
        window.begin(np.array([restarted]), sampler)
    assert_current(window, [400, 200, 0])


@pytest.mark.parametrize("ids", [[0, 1, 2], [2, 0, 1]])
def test_all_may_restart_at_once_in_any_order(ids: list[int]) -> None:
    window, sampler = begun(3)
    for _ in range(300):
        window.advance(sampler)
    window.begin(np.array(ids), sampler)
    assert_current(window, [0, 0, 0])
    for step in range(1, 600):
        window.advance(sampler)
        assert_current(window, [step] * 3)


def test_restart_in_the_same_step_does_not_matter() -> None:
    window, sampler = begun(2)
    for _ in range(3):
        window.begin(np.array([1]), sampler)
    window.advance(sampler)
    assert_current(window, [1, 1])
