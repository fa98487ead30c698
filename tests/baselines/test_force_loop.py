"""Behaviour that the force controllers share: batches, episodes, limits, impact, and singular postures."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from prp_gym.baselines.base.force_integral import ForceError, ScheduledGain
from prp_gym.baselines.base.stiffness_estimator import StiffnessEstimator
from prp_gym.robot import PRPArm
from tests.support.contact_cases import controller, flat, random_cases, random_observation
from tests.support.contact_plant import LIMIT, Wall, simulate

Array = NDArray[np.float64]

FORCE_CONTROLLERS = ("force_inner_position", "parallel_force_position")
GAINS = ("report", "tuned")
OUTER = ScheduledGain(10.0, 0.03, 0.4, StiffnessEstimator(5000.0, 0.5, 0.002))
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
    recording = simulate(weak, cases.joint_position, wall, 40.0 * cases.into, 4.0)
    assert (np.abs(recording.action[-1]).max(axis=-1) > 0.9).all()
    displacement = np.einsum("nk,nk->n", recording.state[0], cases.into)
    tip = np.einsum("nk,nk->n", recording.pose[-1, :, :3] - recording.pose[0, :, :3], cases.into)
    # unlimited, the target would have run ahead at 0.03 m/s for seconds
    assert (displacement - tip < 0.01).all()


@pytest.mark.parametrize("name", FORCE_CONTROLLERS)
@pytest.mark.parametrize("posture", [(0.3, -0.1, np.pi / 2), (0.3, -0.1, -np.pi / 2), (0.3, -0.3, np.pi / 2)])
def test_postures_where_the_tip_s_position_is_singular_are_passed(
    name: str, posture: tuple[float, float, float]
) -> None:
    q = np.array([posture])  # q_3 = ±π/2, and there L = 0 with q_2 = -0.3
    into = np.array([[np.sin(0.3), -np.cos(0.3), 0.0]])
    wall = Wall.ahead(PRPArm().forward_kinematics(q)[:, :3], into, np.full(1, 0.01), np.full(1, 2000.0))
    recording = simulate(controller(name, "tuned"), q, wall, 3.0 * into, 1.2)
    np.testing.assert_allclose(recording.force[-1], 3.0 * into, atol=0.06)
    np.testing.assert_allclose(recording.joint_position[-1, 0, 2], posture[2], atol=1e-3)


def test_free_target_approaches_at_the_stated_speed() -> None:
    memory = OUTER.begin(())
    for _ in range(100):
        _, memory = OUTER.step(memory, error(4.0, 0.0), np.zeros(3), np.zeros(3))
    np.testing.assert_allclose(memory[0], [0.03 * 0.2, 0.0, 0.0], atol=1e-15)


def test_without_a_desired_force_a_free_target_stays() -> None:
    _, memory = OUTER.step(OUTER.begin(()), error(0.0, 0.0), np.zeros(3), np.zeros(3))
    assert not np.any(memory[0])


def test_target_gives_back_the_lag_of_the_approach_at_the_touch_and_only_then() -> None:
    before = (np.array([0.02, 0.0, 0.0]), np.zeros(1), OUTER.estimator.begin(()))
    lag = np.array([0.005, 0.001, 0.0])
    target, touched = OUTER.step(before, error(4.0, 1.0), np.zeros(3), lag)
    np.testing.assert_allclose(target, [0.015, 0.0, 0.0], atol=1e-15)
    again, _ = OUTER.step(touched, error(4.0, 1.0), np.zeros(3), lag)
    np.testing.assert_allclose(again, touched[0], atol=1e-15)
    parting, _ = OUTER.step(before, error(4.0, 1.0), np.zeros(3), -lag)
    np.testing.assert_allclose(parting, [0.02, 0.0, 0.0], atol=1e-15)


@pytest.mark.parametrize(
    ("desired", "measured", "touching", "contact"),
    [
        pytest.param(4.0, 0.39, 0.0, 0.0, id="below the threshold"),
        pytest.param(4.0, 0.41, 0.0, 1.0, id="above it"),
        pytest.param(4.0, 0.21, 1.0, 1.0, id="kept until half of it"),
        pytest.param(4.0, 0.19, 1.0, 0.0, id="lost below half"),
        pytest.param(0.5, 0.26, 0.0, 1.0, id="half a small desired force"),
        pytest.param(0.5, 0.24, 0.0, 0.0, id="below that"),
    ],
)
def test_touch_is_seen_with_hysteresis(
    desired: float, measured: float, touching: float, contact: float
) -> None:
    before = (np.zeros(3), np.array([touching]), OUTER.estimator.begin(()))
    _, memory = OUTER.step(before, error(desired, measured), np.zeros(3), np.zeros(3))
    np.testing.assert_array_equal(memory[1], [contact])


def test_contact_rate_is_the_error_over_the_estimate_and_limited() -> None:
    memory = (np.zeros(3), np.ones(1), OUTER.estimator.begin(()))
    for desired, rate in ((3.0, 10.0 * 2.0 / 5000.0), (0.9, -10.0 * 0.1 / 5000.0), (500.0, 0.03)):
        _, after = OUTER.step(memory, error(desired, 1.0), np.zeros(3), np.zeros(3))
        np.testing.assert_allclose(after[0][0], 0.002 * rate, rtol=1e-12)


def test_new_estimate_does_not_move_the_target() -> None:
    soft, stiff = np.zeros((2, 5))
    soft[:] = [50.0, 0.0, 1.0, 1e-4, 1e-4 * 50.0]
    stiff[:] = [50.0, 0.0, 1.0, 1e-4, 1e-4 * 4000.0]
    before = np.array([0.02, 0.0, 0.0]), np.ones(1)
    targets = [
        OUTER.step((*before, memory), error(2.0, 1.0), np.zeros(3), np.zeros(3))[0]
        for memory in (soft, stiff)
    ]
    np.testing.assert_array_equal(targets[0], targets[1])
