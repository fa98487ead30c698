"""The clock of MuJoCo's Python module: it changes nothing but MuJoCo's own timers."""

import os
import subprocess
import sys

import mujoco
import numpy as np
import pytest

from prp_gym.physics import Physics, PhysicsSettings, to_mjcf
from prp_gym.physics.clock import KEEP, clock_is_read, clock_reading, read_clock
from prp_gym.robot import NOMINAL
from prp_gym.robot.arrays import Array

TIMEOUT = 120.0  # of a new interpreter that imports MuJoCo [s]
STATE = (
    "import mujoco, prp_gym.physics as p; from prp_gym.physics.clock import clock_is_read;"
    "before = clock_is_read(); world = p.Physics(); world.advance(1); print(before, clock_is_read())"
)


def run(code: str, keep: str) -> str:
    command = [sys.executable, "-W", "error", "-c", code]
    variables = {**os.environ, KEEP: keep}
    done = subprocess.run(
        command, capture_output=True, text=True, timeout=TIMEOUT, check=False, env=variables
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def swing(surface: bool) -> tuple[Array, float]:
    """Where a world ends, and how long MuJoCo says that a step of its model took."""
    physics = Physics(NOMINAL, PhysicsSettings(0.001, True, surface), 3)
    physics.set_torque(np.array([[4.0, -20.0, 0.5], [0.0, 0.0, 0.0], [-9.0, 15.0, -2.0]]))
    physics.advance(1500)
    model = physics.model()
    data = mujoco.MjData(model)
    for _ in range(100):
        mujoco.mj_step(model, data)
    return physics.snapshot().integration, float(data.timer[int(mujoco.mjtTimer.mjTIMER_STEP)].duration)


@pytest.mark.parametrize("surface", [False, True])
def test_clock_changes_the_timers_and_no_bit_of_the_state(surface: bool) -> None:
    with clock_reading(True):
        with_clock, timed = swing(surface)
    with clock_reading(False):
        without, nothing = swing(surface)
    np.testing.assert_array_equal(with_clock, without)
    assert timed > 0.0
    assert nothing == 0.0


def test_clock_is_back_as_it_was_after_a_block() -> None:
    for before in (True, False):
        with clock_reading(before):
            with clock_reading(not before):
                assert clock_is_read() is not before
            assert clock_is_read() is before


def test_clock_of_the_user_is_left_alone() -> None:
    calls = []

    def own_clock() -> float:
        calls.append(1)
        return 0.0

    model = mujoco.MjModel.from_xml_string(to_mjcf())
    with clock_reading(True):
        mujoco.set_mjcb_time(own_clock)
        try:
            read_clock(False)
            mujoco.mj_step(model, mujoco.MjData(model))
        finally:
            mujoco.set_mjcb_time(None)
            read_clock(True)
    assert calls


@pytest.mark.parametrize(("keep", "expected"), [("", "True False"), ("0", "True False"), ("1", "True True")])
def test_first_world_takes_the_clock_away_unless_told_not_to(keep: str, expected: str) -> None:
    assert run(STATE, keep) == expected


def test_importing_the_package_takes_nothing_away() -> None:
    code = "import prp_gym; from prp_gym.physics.clock import clock_is_read; print(clock_is_read())"
    assert run(code, "") == "True"
