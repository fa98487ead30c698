"""Metrics of the effort on made-up torques and speeds whose values are known beforehand."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from prp_gym.evaluation.metrics import effort as m
from prp_gym.evaluation.response import root_mean_square
from tests.support.synthetic_episodes import (
    PERIOD,
    ROUNDING,
    TIME,
    Array,
    assert_batch_equals_loop,
    random_motions,
)


def test_energy_of_constant_torque_and_speed_is_power_times_time() -> None:
    torque, velocity = np.tile([10.0, -20.0, 3.0], (100, 1)), np.tile([1.0, 0.5, -2.0], (101, 1))
    # |10·1| + |20·0.5| + |3·2| W for one second, or for two, whatever the signs
    assert m.mechanical_energy(torque, velocity, 0.01) == pytest.approx(26.0, rel=ROUNDING)
    assert m.mechanical_energy(torque, velocity, 0.02) == pytest.approx(52.0, rel=ROUNDING)


def test_energy_of_a_uniform_acceleration_is_force_times_way() -> None:
    velocity = np.zeros((101, 3))
    velocity[:, 1] = 4.0 * TIME  # the trapezoidal rule is exact: 2 m in a second
    torque = np.tile([5.0, -20.0, 5.0], (100, 1))
    assert m.mechanical_energy(torque, velocity, PERIOD) == pytest.approx(40.0, rel=ROUNDING)


def test_root_mean_square_and_rate_of_known_torques() -> None:
    ramp = np.arange(100.0)[:, None] * PERIOD * np.array([3.0, -50.0, 0.0])
    np.testing.assert_allclose(m.torque_rate(ramp, PERIOD), [3.0, 50.0, 0.0], rtol=1e-9)
    square = np.tile([2.0, 3.0, 0.0], (100, 1)) * (-1.0) ** np.arange(100)[:, None]
    np.testing.assert_allclose(root_mean_square(square), [2.0, 3.0, 0.0], rtol=ROUNDING)
    np.testing.assert_allclose(m.torque_rate(square, PERIOD), [400.0, 600.0, 0.0], rtol=ROUNDING)


def test_energy_of_a_single_joint_is_its_own() -> None:
    torque, velocity = np.full((100, 1), -10.0), np.full((101, 1), 0.5)
    assert m.mechanical_energy(torque, velocity, 0.01) == pytest.approx(5.0, rel=ROUNDING)


def test_torque_rate_of_one_step_does_not_exist() -> None:
    assert np.isnan(m.torque_rate(np.ones((2, 1, 3)), 0.1)).all()


@pytest.mark.parametrize(("joints", "share"), [(1, 150.0), (3, 50.0)])
def test_share_of_joints_is_relative_to_their_number(joints: int, share: float) -> None:
    counts = np.array([0.0, 1.0, 2.0, 3.0])
    assert m.share_of_joints(counts, joints) == pytest.approx(share, rel=ROUNDING)


BATCHED: dict[str, Callable[[Array, Array], NDArray[Any]]] = {
    "mechanical_energy": lambda actual, desired: m.mechanical_energy(desired[..., 1:, :], actual, PERIOD),
    "torque_rate": lambda actual, desired: m.torque_rate(actual, PERIOD),
    "share_of_joints": lambda actual, desired: m.share_of_joints(actual[..., 0], 3),
}


@pytest.mark.parametrize("name", BATCHED)
@pytest.mark.parametrize("joints", [1, 3])
def test_batch_equals_a_loop_over_single_episodes(name: str, joints: int) -> None:
    actual, desired = random_motions(1, 2, 4)
    assert_batch_equals_loop(BATCHED[name], actual[..., :joints], desired[..., :joints])
