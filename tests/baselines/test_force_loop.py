"""Behaviour that the force controllers share: batches, episodes, limits, impact, and singular postures."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from prp_gym.baselines.base.approach_speed import FixedSpeed, SpeedForForce, braking_time
from prp_gym.baselines.base.force_integral import ForceError, ScheduledGain, TipMotion
from prp_gym.baselines.base.stiffness_estimator import StiffnessEstimator
from prp_gym.robot import PRPArm
from tests.support.contact_cases import controller, flat, random_cases, random_observation, repeated
from tests.support.contact_plant import LIMIT, Wall, simulate

Array = NDArray[np.float64]

FORCE_CONTROLLERS = ("force_inner_position", "parallel_force_position")
GAINS = ("report", "tuned")
ESTIMATOR = StiffnessEstimator(5000.0, 0.5, 0.002, greatest_stiffness=5000.0)
OUTER = ScheduledGain(10.0, FixedSpeed(0.03, 0.03), 0.4, ESTIMATOR)
STILL = TipMotion(np.zeros(3), np.zeros(3), np.zeros(3))
ALONG_X = np.array([1.0, 0.0, 0.0])


def error(desired: float, measured: float) -> ForceError:
    return ForceError.of(desired * ALONG_X, measured * ALONG_X)


@pytest.mark.parametrize("name", FORCE_CONTROLLERS)
@pytest.mark.parametrize("gains", GAINS)
def test_batch_equals_the_single_controller_in_every_row(name: str, gains: str) -> None:
    chosen = controller(name, gains)
    first, second = random_observation(3, 6), random_observation(21, 6)
    states = chosen.initial_state(first)
    _, states = chosen.control(first, states)
    torque, after = chosen.control(second, states)
    for row in range(6):
        one = {key: value[row] for key, value in first.items()}
        two = {key: value[row] for key, value in second.items()}
        _, state = chosen.control(one, chosen.initial_state(one))
        alone, state = chosen.control(two, state)
        # torques up to 1e6, a few dozen operations whose order differs
        np.testing.assert_allclose(alone, torque[row], rtol=1e-12, atol=1e-9)
        assert len(state) == len(after)
        for single, whole in zip(state, after, strict=True):
            np.testing.assert_allclose(single, whole[row], rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize("name", FORCE_CONTROLLERS)
@pytest.mark.parametrize("gains", GAINS)
def test_episode_starts_anew_where_it_starts_and_only_there(name: str, gains: str) -> None:
    chosen = controller(name, gains, limit=1e9 * LIMIT)  # no actuator reaches its limit
    before, now = random_observation(8, 3), random_observation(4, 3)
    for observed in (before, now):
        observed["desired_force"] = 2.0 * observed["contact_force"]  # pressing: the estimate learns
    faint = now["contact_force"][1]
    faint *= 0.3 / np.linalg.norm(faint)  # kept as a touch, not taken for a new one
    observation = flat(now)
    _, state = chosen.predict(flat(before))
    starts = np.array([False, True, False])
    action, after = chosen.predict(observation, state, starts)
    going, kept = chosen.predict(observation, state)
    begun, fresh = chosen.predict(observation)
    assert after is not None
    assert kept is not None
    assert fresh is not None
    np.testing.assert_array_equal(action, np.where(starts[:, None], begun, going))
    for mixed, old, new in zip(after, kept, fresh, strict=True):
        np.testing.assert_array_equal(mixed, np.where(starts[:, None], new, old))
        assert not np.array_equal(old[1], new[1])


@pytest.mark.parametrize("name", FORCE_CONTROLLERS)
@pytest.mark.parametrize("gains", GAINS)
def test_integral_stands_still_where_an_actuator_is_at_its_limit(name: str, gains: str) -> None:
    observed = random_observation(5, 2)
    observed["joint_velocity"] *= 0.0
    observed["end_effector_velocity"] *= 0.0
    observed["desired_velocity"] *= 0.0
    observed["desired_acceleration"] *= 0.0
    observed["contact_force"] *= 0.0
    observed["desired_pose"] = observed["end_effector_pose"].copy()
    observed["desired_force"] = np.tile(1e-3 * ALONG_X, (2, 1))  # so that the report's K_F pulls little
    pressed = observed["contact_force"].copy()
    pressed[0] = [0.0, 0.0, 3e3]  # holding this exceeds the limits, along z: no error along x
    chosen = controller(name, gains)
    action, state = chosen.predict(flat({**observed, "contact_force": pressed}))
    assert state is not None
    assert np.abs(action[0]).max() == 1.0
    assert np.abs(action[1]).max() < 1.0
    assert not np.any(state[0][0])
    assert state[0][1, 0] > 0.0


@pytest.mark.parametrize("name", FORCE_CONTROLLERS)
def test_saturation_on_the_way_does_not_wind_the_integral(name: str) -> None:
    """A desired force beyond what the slide can hold, then one that it can."""
    cases = random_cases(6, 4)
    wall = replace(cases.wall, stiffness=np.full(4, 3000.0))
    weak = controller(name, "tuned", limit=np.array([50.0, 12.0, 10.0]))
    recording = simulate(weak, cases.joint_position, wall, 40.0 * cases.into, 2.0)
    assert (np.abs(recording.action[-1]).max(axis=-1) > 0.9).all()
    displacement = np.einsum("nk,nk->n", recording.state[0], cases.into)
    tip = np.einsum("nk,nk->n", recording.pose[-1, :, :3] - recording.pose[0, :, :3], cases.into)
    # not held, the target would have run ahead at up to 1.5 m/s for seconds
    assert (displacement - tip < 0.02).all()


@pytest.mark.parametrize("name", FORCE_CONTROLLERS)
def test_postures_where_the_tip_s_position_is_singular_are_passed(name: str) -> None:
    # q_3 = ±π/2, and there L = 0 with q_2 = -0.3
    q = np.array([[0.3, -0.1, np.pi / 2], [0.3, -0.1, -np.pi / 2], [0.3, -0.3, np.pi / 2]])
    into = np.tile([np.sin(0.3), -np.cos(0.3), 0.0], (3, 1))
    wall = Wall.ahead(PRPArm().forward_kinematics(q)[:, :3], into, np.full(3, 0.01), np.full(3, 2000.0))
    recording = simulate(controller(name, "tuned"), q, wall, 3.0 * into, 1.2)
    np.testing.assert_allclose(recording.force[-1], 3.0 * into, atol=0.06)
    np.testing.assert_allclose(recording.joint_position[-1, :, 2], q[:, 2], atol=1e-3)


def test_free_target_approaches_at_the_stated_speed() -> None:
    memory = OUTER.begin(())
    for _ in range(100):
        _, memory = OUTER.step(memory, error(4.0, 0.0), STILL)
    np.testing.assert_allclose(memory[0], [0.03 * 0.2, 0.0, 0.0], atol=1e-15)


def test_without_a_desired_force_a_free_target_stays() -> None:
    _, memory = OUTER.step(OUTER.begin(()), error(0.0, 0.0), STILL)
    assert not np.any(memory[0])


def test_target_gives_back_the_lag_of_the_approach_at_the_touch_and_only_then() -> None:
    before = (np.array([0.02, 0.0, 0.0]), np.zeros(1), np.zeros(1), ESTIMATOR.begin(()))
    lag = np.array([0.005, 0.001, 0.0])
    target, touched = OUTER.step(before, error(4.0, 1.0), STILL._replace(lag=lag))
    np.testing.assert_allclose(target, [0.015, 0.0, 0.0], atol=1e-15)
    again, _ = OUTER.step(touched, error(4.0, 1.0), STILL._replace(lag=lag))
    np.testing.assert_allclose(again, touched[0], atol=1e-15)
    parting, _ = OUTER.step(before, error(4.0, 1.0), STILL._replace(lag=-lag))
    np.testing.assert_allclose(parting, [0.02, 0.0, 0.0], atol=1e-15)


@pytest.mark.parametrize(
    ("desired", "measured", "touching", "contact"),
    [
        pytest.param(4.0, 0.39, 0.0, 0.0, id="below the threshold"),
        pytest.param(4.0, 0.41, 0.0, 1.0, id="above it"),
        pytest.param(4.0, 0.21, 1.0, 1.0, id="kept until half of it"),
        pytest.param(4.0, 0.19, 1.0, -1.0, id="lost below half"),
        pytest.param(0.5, 0.26, 0.0, 1.0, id="half a small desired force"),
        pytest.param(0.5, 0.24, 0.0, 0.0, id="below that"),
    ],
)
def test_touch_is_seen_with_hysteresis(
    desired: float, measured: float, touching: float, contact: float
) -> None:
    before = (np.zeros(3), np.array([touching]), np.zeros(1), ESTIMATOR.begin(()))
    _, memory = OUTER.step(before, error(desired, measured), STILL)
    np.testing.assert_array_equal(memory[1], [contact])


def test_contact_rate_is_the_error_over_the_estimate_and_limited() -> None:
    for desired, rate in ((3.0, 10.0 * 2.0 / 5000.0), (0.9, -10.0 * 0.1 / 5000.0), (500.0, 0.03)):
        smooth = np.array([desired - 1.0])  # as after a long time with this error
        memory = (np.zeros(3), np.ones(1), smooth, ESTIMATOR.begin(()))
        _, after = OUTER.step(memory, error(desired, 1.0), STILL)
        np.testing.assert_allclose(after[0][0], 0.002 * rate, rtol=1e-12)


def test_speed_limit_in_contact_allows_for_the_uncertainty_of_the_estimate() -> None:
    estimator = replace(ESTIMATOR, initial_stiffness=100.0)
    outer = replace(OUTER, speed=SpeedForForce(5000.0, 0.005, np.inf, 0.0, 0.25), estimator=estimator)
    memory = (np.zeros(3), np.ones(1), np.array([2.0]), ESTIMATOR.begin(()))
    _, after = outer.step(memory, error(3.0, 1.0), STILL)
    # before the first measurement σ_K = 0.05 N / 1e-5 m, so that the surface may be the stiffest, of 5000 N/m
    np.testing.assert_allclose(after[0][0], 0.002 * 3.0 / (5000.0 * 0.005), rtol=1e-12)


def test_error_passes_a_low_pass_whose_time_constant_is_damping_over_stiffness() -> None:
    learned = np.array([50.0, 0.0, 0.0, 1.0, 1e-2, 0.0, 1.0, 1e-2 * 50.0, 10.0])  # K = 50 N/m, D = 10 N s/m
    memory = (np.zeros(3), np.ones(1), np.zeros(1), learned)
    _, after = OUTER.step(memory, error(3.0, 1.0), STILL)
    # D/K = 0.2 s, by the backward difference over 2 ms; one more measurement moves the estimates a little
    np.testing.assert_allclose(after[2], 2.0 * 0.002 / (0.002 + 0.2), rtol=0.05)


def test_new_estimate_does_not_move_the_target() -> None:
    soft, stiff = np.zeros((2, 9))
    soft[:] = [50.0, 0.0, 0.0, 1.0, 1e-4, 0.0, 0.0, 1e-4 * 50.0, 0.0]
    stiff[:] = [50.0, 0.0, 0.0, 1.0, 1e-4, 0.0, 0.0, 1e-4 * 4000.0, 0.0]
    before = np.array([0.02, 0.0, 0.0]), np.ones(1), np.zeros(1)
    targets = [OUTER.step((*before, memory), error(2.0, 1.0), STILL)[0] for memory in (soft, stiff)]
    np.testing.assert_array_equal(targets[0], targets[1])


def test_speed_follows_from_the_force_within_its_bounds() -> None:
    speed = SpeedForForce(5000.0, 0.005, 20.0, least=0.02, largest=0.25, factor=1.2)
    desired, threshold = np.array([0.5, 1.0, 3.0, 6.0, 30.0]), np.full(5, 0.25)
    # 6 N: 1.2 · 5.75/25 = 0.276 m/s could not be braked with 20 m/s² within 5.75/5000 m
    expected = [0.02, 1.2 * 0.75 / 25.0, 1.2 * 2.75 / 25.0, (40.0 * 5.75 / 5000.0) ** 0.5, 0.25]
    np.testing.assert_allclose(speed.before_contact(desired, threshold), expected, rtol=1e-15)
    soft = speed.in_contact(np.array([1.0]), np.array([5.0]))
    stiff = speed.in_contact(np.array([1.0]), np.array([5000.0]))
    np.testing.assert_allclose([soft[0], stiff[0]], [0.25, 0.04], rtol=1e-15)


@pytest.mark.parametrize("omega", [60.0, 120.0])
def test_critically_damped_loop_runs_on_by_the_braking_distance(omega: float) -> None:
    """x¨ = -2 ω ẋ - ω² x from x = 0 with the speed 1: its largest x, integrated in steps of a microsecond."""
    step, x, v, peak = 1e-6, 0.0, 1.0, 0.0
    while v > 0.0:
        v += step * (-2.0 * omega * v - omega**2 * x)
        x += step * v
        peak = max(peak, x)
    # a step of 1e-6 s over 1/ω = 8 ms
    assert braking_time(0.0, omega**2, 1.0) == pytest.approx(peak, rel=1e-3)
    assert braking_time(0.002, omega**2, 1.0) == pytest.approx(0.002 + peak, rel=1e-3)


@pytest.mark.parametrize("stiffness", [300.0, 5000.0])
def test_speed_that_can_be_braked_leaves_the_force_below_the_desired_one(stiffness: float) -> None:
    """A tip of constant deceleration, from the threshold on a spring, integrated in steps of 10 us."""
    speed = SpeedForForce(stiffness, 1e-6, 20.0, 0.0, 10.0).before_contact(np.array([4.0]), np.array([0.5]))
    x, v = 0.0, float(speed[0])
    while v > 0.0:
        x, v = x + 1e-5 * v, v - 1e-5 * 20.0
    # a step of 1e-5 s of some 10 to 50 ms
    assert 0.5 + stiffness * x == pytest.approx(4.0, rel=2e-3)


def test_prediction_keeps_a_fast_loop_stable_if_the_inner_loop_is_damped() -> None:
    """ω_c far above K_D/M_d = 2 ζ ω: by Routh stable for every ω_c if K_D² > M_d K_P, that is ζ > 1/2."""
    damping_ratio, decays = np.array([[1.0], [0.7], [0.3]]), [True, True, False]
    omega, step, spring = 60.0, 4e-5, 800.0
    estimator = StiffnessEstimator(spring, 1e3, step, greatest_stiffness=spring)
    outer = ScheduledGain(20.0 * omega, FixedSpeed(1e6, 0.0), 0.1, estimator)
    x, v, memory, forces = np.zeros((3, 1)), np.zeros((3, 1)), outer.begin((3,)), []
    memory = (memory[0], np.ones((3, 1)), *memory[2:])  # in contact from the start
    for _ in range(12_000):
        tip = TipMotion(x * ALONG_X, v * ALONG_X, 2.0 * damping_ratio / omega * v * ALONG_X)
        pressing = ForceError.of(20.0 * ALONG_X, (10.0 + spring * x) * ALONG_X)
        target, memory = outer.step(memory, pressing, tip)
        v = v + step * (omega**2 * (target[:, :1] - x) - 2.0 * damping_ratio * omega * v)
        x = x + step * v
        forces.append(10.0 + spring * x[:, 0])
    late = np.abs(np.array(forces[-1000:]) - 20.0).max(axis=0)
    for own, stable in zip(late, decays, strict=True):
        assert (own < 0.05) if stable else (own > 1.0)


def test_target_returns_slowly_to_a_surface_that_it_has_lost() -> None:
    outer = replace(OUTER, speed=SpeedForForce(10.0, 0.005, np.inf, least=0.02, largest=0.25))
    state = (np.zeros(3), np.zeros(1), np.zeros(1), ESTIMATOR.begin(()))
    _, fast = outer.step(state, error(4.0, 0.0), STILL)
    _, touched = outer.step(state, error(4.0, 2.0), STILL)
    _, lost = outer.step(touched, error(4.0, 0.0), STILL)
    np.testing.assert_allclose(fast[0][0], 0.002 * 0.25, rtol=1e-12)
    # ω_c e/K̂ = 10 · 4/5000 is below the least speed
    np.testing.assert_allclose(lost[0][0] - touched[0][0], 0.002 * 0.02, rtol=1e-9)


def test_damped_surface_is_pressed_without_a_limit_cycle() -> None:
    """Without the low pass a damping of 10 N s/m on 50 N/m and ω_c = 20 rad/s bounces for ever."""
    cases = repeated(random_cases(6, 4), 2)
    wall = replace(cases.wall, stiffness=np.repeat([50.0, 500.0], 4), damping=np.full(8, 10.0))
    chosen = controller("force_inner_position", "tuned")
    recording = simulate(chosen, cases.joint_position, wall, 2.5 * cases.into, 3.0)
    late = np.einsum("tnk,nk->tn", recording.force[-250:], cases.into)
    # a gap of up to 4 cm at the least speed, 0.02 m/s, then a decay at 20 rad/s with the ideal model
    np.testing.assert_allclose(late, 2.5, atol=0.02)
