"""Simulated time goes beside real time, and it shows where it cannot."""

import pytest

from prp_gym.viewing.real_time import RealTime

PERIOD = 0.002


class Clock:
    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


def run(real_time: RealTime, clock: Clock, frames: int, frame: float, capacity: int) -> int:
    """Actions taken over some frames by a machine that can take `capacity` actions in each."""
    total = 0
    for _ in range(frames):
        clock.now += frame
        taken = min(real_time.due(PERIOD), capacity)
        real_time.taken(taken * PERIOD)
        total += taken
    return total


@pytest.mark.parametrize("speed", [0.1, 1.0, 3.0])
def test_actions_are_due_at_the_chosen_speed(speed: float) -> None:
    clock = Clock()
    real_time = RealTime(clock)
    real_time.speed = speed
    total = run(real_time, clock, 300, 1 / 30, 10_000)
    assert total * PERIOD == pytest.approx(10.0 * speed, abs=PERIOD)
    assert real_time.factor == pytest.approx(speed, rel=0.02)
    assert not real_time.falls_behind


def test_slow_machine_shows_as_a_factor_below_the_chosen_speed() -> None:
    clock = Clock()
    real_time = RealTime(clock)
    run(real_time, clock, 100, 0.05, 10)  # 20 ms of simulated time in 50 ms
    assert real_time.factor == pytest.approx(0.4, rel=0.02)
    assert real_time.falls_behind


def test_long_gap_is_lost_and_not_caught_up() -> None:
    clock = Clock()
    real_time = RealTime(clock)
    clock.now += 60.0
    assert real_time.due(PERIOD) * PERIOD == pytest.approx(0.1)
    assert real_time.due(PERIOD) == 0


def test_pause_does_not_count() -> None:
    clock = Clock()
    real_time = RealTime(clock)
    run(real_time, clock, 100, 0.05, 10)
    clock.now += 30.0
    real_time.start()
    assert real_time.due(PERIOD) == 0
    assert not real_time.falls_behind
