"""Closed forms of contact against simulation, in the report's scenario.

In steady contact the controllers' closed loops are springs: no force depends on the control rate, so that the
report's figures hold at 500 Hz as at 1000 Hz. Tolerances are those of the design, in percent; what the
simulation itself leaves is stated where it is larger than rounding.
"""

from contextlib import closing
from typing import Any

import gymnasium
import numpy as np
import pytest
from numpy.typing import NDArray

import prp_gym
from prp_gym.evaluation.episode import record_episode
from prp_gym.evaluation.rollout import Rollout
from tests.support.contact_episodes import environment, side_by_side

Array = NDArray[np.float64]

COMPLIANCE, IMPEDANCE, ADMITTANCE = "PRP-Compliance-v0", "PRP-Impedance-v0", "PRP-Admittance-v0"
FORCE, FORCE_POSITION = "PRP-Force-v0", "PRP-ForcePosition-v0"
RATES = (500, 1000)


def run(environment_id: str, controller: str, gains: str = "report", **options: Any) -> Rollout:
    """One episode of the report's scenario; options of the controller are `integral_gain` and `origin`."""
    settings = {name: options.pop(name) for name in ("integral_gain", "origin") if name in options}
    with closing(gymnasium.make(environment_id, scenario="report", **options)) as env:
        return record_episode(prp_gym.make_baseline(controller, env, gains, **settings), env, seed=0)


def run_on(
    environment_id: str, controller: str, stiffness: Array, gains: str = "report", **options: Any
) -> dict[str, Array]:
    """Ground truth (T, N, size) of episodes of the report's scenario on surfaces of some stiffnesses (N)."""
    env = environment(environment_id, scenario="report", **options)
    return side_by_side(prp_gym.make_baseline(controller, env, gains), env, surface_stiffness=stiffness)


def along_y(force: Array) -> Array:
    """The forces (N, 3) with these values (N) along y [N]."""
    return np.stack([np.zeros_like(force), force, np.zeros_like(force)], axis=-1)


def final_force(rollout: Rollout) -> Array:
    """Force by the tip on the surface at the end (3) [N]."""
    force: Array = rollout.fields["contact_force"][-1]
    return force


def spring_force(stiffness: Array, own: float, depth: float) -> Array:
    """Two springs in series over a depth [m]: K K_P/(K + K_P) depth [N]."""
    return stiffness * own / (stiffness + own) * depth


@pytest.mark.parametrize("frequency", RATES)
@pytest.mark.parametrize(
    ("environment_id", "controller", "duration"),
    [(COMPLIANCE, "compliance", 5.0), (IMPEDANCE, "impedance", 3.0)],
)
def test_surface_is_pressed_as_by_a_spring(
    environment_id: str, controller: str, duration: float, frequency: int
) -> None:
    stiffness = np.array([1.0, 50.0, 1000.0])
    expected = spring_force(stiffness, 50.0, 0.1)
    np.testing.assert_allclose(expected, [0.09804, 2.5, 4.7619], rtol=0, atol=5e-5)  # the printed digits
    fields = run_on(environment_id, controller, stiffness, control_frequency=frequency, duration=duration)
    # transients have decayed below this tolerance: the design's 0.2 % are not needed
    np.testing.assert_allclose(fields["contact_force"][-1], along_y(expected), rtol=1e-6, atol=1e-6)


def test_impedance_with_the_gains_of_the_figures_presses_harder_and_meets_the_surface_as_plotted() -> None:
    """Steady forces, and the highest y of the tip from figures 35 to 37 without their feed-forward error."""
    stiffness = np.array([1.0, 50.0, 1000.0])
    expected = spring_force(stiffness, 75.0, 0.1)
    np.testing.assert_allclose(expected, [0.0987, 3.0, 6.977], rtol=0, atol=5e-4)  # the printed digits
    fields = run_on(IMPEDANCE, "impedance", stiffness, "figures", control_frequency=1000, duration=4.0)
    # 4 s leave 4e-8 of the transient
    np.testing.assert_allclose(fields["contact_force"][-1], along_y(expected), rtol=1e-6, atol=1e-6)
    # a fourth-order integration of the same loop gives these digits; 1 ms steps move the peak by up to 0.1 mm
    highest = fields["end_effector_pose"][..., 1].max(axis=0)
    np.testing.assert_allclose(highest, [-0.34081, -0.36760, -0.42863], rtol=0, atol=1.2e-4)


@pytest.mark.parametrize("frequency", RATES)
def test_compliant_frame_gives_way_as_a_spring(frequency: int) -> None:
    stiffness = np.array([1.0, 25.0, 50.0, 1000.0])
    expected = spring_force(stiffness, 20.0, 0.05)
    printed = [0.0476, 0.5556, 0.7143, 0.9804]
    np.testing.assert_allclose(expected, printed, rtol=0, atol=5e-5)  # the printed digits
    options: dict[str, Any] = {"reference": "hold", "control_frequency": frequency, "duration": 4.5}
    fields = run_on(ADMITTANCE, "admittance", stiffness, **options)
    # the slowest pole is 2.8 1/s: 3 s after the reference came to rest leave 2e-4 of it, 4e-6 of the forces
    np.testing.assert_allclose(fields["contact_force"][-1], along_y(expected), rtol=1e-4, atol=1e-6)


@pytest.mark.parametrize(
    ("settings", "printed"),
    [
        ({}, 1.0),
        ({"integral_gain": 0.0}, 0.9706),
        ({"integral_gain": 0.0, "origin": "base"}, 1.0235),
    ],
)
def test_force_comes_out_as_the_inner_loop_predicts(settings: dict[str, Any], printed: float) -> None:
    K, K_F, f_d, x_0, x_e = 5.0, 10.0, 1.0, -0.54, -0.44
    start = -0.1 if settings.get("origin") != "base" else -x_e
    proportional = K * (start + K_F * f_d) / (1 + K * K_F)
    assert x_0 - x_e == pytest.approx(-0.1)
    expected = proportional if settings else f_d
    assert expected == pytest.approx(printed, abs=5e-5)  # the printed digits
    duration = 1.0 if settings else 5.0
    rollout = run(FORCE, "force_inner_position", torque_limit=None, duration=duration, **settings)
    # the PI's slow mode decays with 0.5 1/s, but from 5e-5 N: 5 s leave 4e-6 N; without it the inner loop's
    # poles have decayed within a second
    np.testing.assert_allclose(final_force(rollout), [0.0, expected, 0.0], rtol=1e-4, atol=1e-6)


@pytest.mark.parametrize("frequency", RATES)
def test_parallel_control_reaches_the_force_and_gives_up_the_position_along_it(frequency: int) -> None:
    rollout = run(
        FORCE_POSITION,
        "parallel_force_position",
        torque_limit=None,
        duration=6.0,  # leaves 2 % of these tolerances
        control_frequency=frequency,
    )
    np.testing.assert_allclose(final_force(rollout), [0.5, 0.0, 0.0], rtol=1e-3, atol=1e-6)  # design: 0.2 %
    surface = -(0.3 - 0.2 + 0.24 * np.cos(np.pi / 6))  # x of the pose of (-π/2, -0.2, -π/6)
    position = rollout.fields["end_effector_pose"][-1, :3]
    np.testing.assert_allclose(position, [surface + 0.5 / 50.0, -0.4, 0.03], atol=1e-5)  # design: 1e-4 m


def test_parallel_control_as_run_leaves_the_joint_limits() -> None:
    rollout = run(
        FORCE_POSITION,
        "parallel_force_position",
        start="home",
        surface_stiffness=1.0,
        torque_limit=None,
        duration=12.0,  # leaves a fifth of these tolerances
    )
    np.testing.assert_allclose(final_force(rollout)[0], 0.5, rtol=2e-3)
    assert rollout.fields["joint_position"][-1, 1] == pytest.approx(-0.7, abs=1e-3)  # the printed digit


RINGING = [(50, 1000.0, False), (50, 2000.0, True), (100, 2000.0, False), (100, 5000.0, True)]


@pytest.mark.parametrize(("frequency", "stiffness", "rings"), RINGING)
def test_impedance_rings_where_the_held_force_takes_all_of_its_damping(
    frequency: int, stiffness: float, rings: bool
) -> None:
    B, M_d, K_D = 1.549, 0.5, 10.0  # along the slide at home
    taken = (B / M_d - 1.0) * stiffness / (2.0 * frequency)
    assert (taken > B / M_d * K_D) == rings
    rollout = run(
        IMPEDANCE, "impedance", "tuned_50hz", surface_stiffness=stiffness, control_frequency=frequency
    )
    force = np.linalg.norm(rollout.fields["contact_force"], axis=-1)[rollout.time > 4.0]
    # either it has come to rest, or it still swings by more than it presses
    assert np.ptp(force) > force.mean() if rings else np.ptp(force) < 1e-2
