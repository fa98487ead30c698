"""Settling, limit cycles and kinds of failure on made-up episodes whose outcome is known beforehand."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from prp_gym import list_envs
from prp_gym.evaluation import METRICS, Rollout, episode_metrics
from prp_gym.evaluation.failure import FAILURES
from prp_gym.evaluation.response import oscillates_for_good, time_settled
from prp_gym.evaluation.scoring import scoring_of
from prp_gym.tasks.settling.force_settling import ForceSettling
from prp_gym.tasks.settling.motion_settling import MotionSettling
from tests.support.synthetic_episodes import Array, joint_fields, make_rollout, pose

SAMPLES = 501
TIME = np.linspace(0.0, 5.0, SAMPLES)
STILL = np.zeros((SAMPLES, 1))


def kind_of(rollout: Rollout) -> str:
    """The kind of failure of an episode; empty for none."""
    shares = episode_metrics(rollout)["failure"]
    assert sorted(set(shares.tolist())) in ([0.0], [0.0, 100.0])
    found = [name for name, share in zip(FAILURES, shares, strict=True) if share]
    assert len(found) <= 1
    return found[0] if found else ""


def joint_episode(error: Array, **changes: Any) -> Rollout:
    """A constant reference of 1 rad, and an error of joint 1 (T) [rad] at all but the first sample."""
    goal = np.tile([1.0, 0.0, 0.0], (SAMPLES, 1))
    actual = goal.copy()
    actual[:, 0] -= error
    actual[0] = 0.0
    return make_rollout(joint_fields(actual, goal), 3, **changes)


def press_episode(force: Array, **changes: Any) -> Rollout:
    """A tip that stays where it should and presses with a force (T) [N], 2 N being desired."""
    rest = pose(np.zeros((SAMPLES, 3)), np.zeros((SAMPLES, 2)))
    along = np.array([0.0, 1.0, 0.0])
    fields = {
        "end_effector_pose": rest,
        "desired_pose": rest,
        "contact_force": force[:, None] * along,
        "desired_force": np.full((SAMPLES, 1), 2.0) * along,
    }
    return make_rollout(fields, 3, environment_id="PRP-Force-v0", **changes)


@pytest.mark.parametrize("environment_id", list_envs())
def test_every_task_of_the_suite_declares_when_its_responses_settle(environment_id: str) -> None:
    assert scoring_of(environment_id).settling is not None


@pytest.mark.parametrize(
    ("error", "time"),
    [(0.0, 0.01), (0.019, 0.01), (0.021, np.inf)],  # 2 % of the move of 1 rad
)
def test_response_to_a_goal_settles_within_two_percent_of_the_move(error: float, time: float) -> None:
    values = episode_metrics(joint_episode(np.full(SAMPLES, error)))
    assert values["response_settling_time"] == pytest.approx(time, abs=1e-9)
    assert values["unsettled"] == (100.0 if np.isinf(time) else 0.0)


def test_response_that_settles_in_the_last_tenth_has_not_settled() -> None:
    for settles, expected in ((4.4, 4.4), (4.6, np.inf)):
        error = np.where(settles - 1e-9 > TIME, 0.5, 0.0)
        found = episode_metrics(joint_episode(error))["response_settling_time"]
        assert found == pytest.approx(expected, abs=1e-9)


def test_moving_reference_is_followed_within_a_centimetre_at_the_tip() -> None:
    criterion = MotionSettling("actual", "desired", "desired", (0.02, 0.01), 1.0, 0.1, 0.02)
    desired = np.stack([TIME, 0.1 * TIME], axis=-1)
    for errors, norm in (((0.02, 0.0), 1.0), ((0.0, 0.01), 1.0), ((0.012, 0.008), 1.0)):
        fields = {"desired": desired, "actual": desired - errors}
        (deviation,) = criterion.deviations(fields)
        np.testing.assert_allclose(np.linalg.norm(deviation, axis=-1), norm, rtol=1e-9)


def test_resting_reference_near_the_start_has_a_tolerance_of_a_millimetre() -> None:
    criterion = MotionSettling("actual", "desired", "desired", (0.01,), 1.0, 0.1, 0.02)
    fields = {"desired": STILL, "actual": STILL - 0.001}
    np.testing.assert_allclose(criterion.deviations(fields)[0], 1.0, rtol=1e-12)


IN_AND_OUT = MotionSettling("actual", "desired", "desired", (0.01,), 1.0, 1.0, before_reversals=True)


@pytest.mark.parametrize("turn", [2.0, 2.003])  # at a sample, and between two
def test_reference_that_goes_in_and_out_turns_back_once(turn: float) -> None:
    position = np.interp(TIME, [0.5, turn, 3.5], [0.0, 0.1, -0.05])[:, None]
    (found,) = IN_AND_OUT.reversals({"desired": position})
    assert TIME[found] == pytest.approx(turn, abs=0.01)
    straight = MotionSettling("actual", "desired", "desired", (0.01,), 1.0, 1.0)
    assert straight.reversals({"desired": position}) == ()


@pytest.mark.parametrize("reference", [0.0 * TIME, np.minimum(TIME, 2.0), np.round(TIME, 1)])
def test_reference_that_rests_or_goes_on_never_turns_back(reference: Array) -> None:
    noise = 1e-16 * np.cos(100.0 * TIME)  # rounding
    assert IN_AND_OUT.reversals({"desired": (reference + noise * reference.any())[:, None]}) == ()


@pytest.mark.parametrize(
    ("low", "high", "expected"),
    [
        (0.0, 1.7, 1.7),  # settles before 1.8 s, a tenth of the 2 s before the reversal
        (0.0, 1.9, np.inf),
        (1.0, 3.0, np.inf),
        (2.1, 3.0, 3.0),  # a transient after the reversal, which settles
        (2.1, 4.6, np.inf),
    ],
)
def test_response_has_to_settle_before_its_reference_turns_back(
    low: float, high: float, expected: float
) -> None:
    outside = np.where((low - 1e-9 < TIME) & (high - 1e-9 > TIME), 2.0, 0.0)[:, None]
    assert time_settled(TIME, [outside], [round(2.0 / TIME[1])]) == pytest.approx(expected)


@pytest.mark.parametrize(("desired", "tolerance"), [(10.0, 0.5), (4.0, 0.2), (1.0, 0.2)])
def test_force_settles_within_five_percent_but_not_below_what_the_sensor_resolves(
    desired: float, tolerance: float
) -> None:
    criterion = ForceSettling(0.05, 0.2, 0.01, 0.042)
    rest = np.zeros((SAMPLES, 6))
    moved = rest + np.array(
        [0.01, 7.0, 0.0, 0.042, 0.0, 9.0]
    )  # the 7 m are along the force, the 9 rad about γ
    along = np.array([0.0, 1.0, 0.0])
    fields = {
        "contact_force": STILL + (desired - tolerance) * along,
        "desired_force": STILL + desired * along,
        "end_effector_pose": moved,
        "desired_pose": rest,
    }
    for group in criterion.deviations(fields):
        np.testing.assert_allclose(np.linalg.norm(group, axis=-1), 1.0, rtol=1e-9)


def test_undefined_deviation_never_settles() -> None:
    assert time_settled(TIME, [np.full((SAMPLES, 1), np.nan)]) == np.inf


@pytest.mark.parametrize(
    ("signal", "cycle"),
    [
        (1.5 * np.sin(2 * np.pi * 3 * TIME), True),
        (5.0 + 1.5 * np.sin(2 * np.pi * 3 * TIME), True),  # about another middle than 0
        (0.9 * np.sin(2 * np.pi * 3 * TIME), False),  # within the tolerance
        (20.0 * np.exp(-1.5 * TIME) * np.sin(2 * np.pi * 3 * TIME), False),  # decays
        (1.5 * np.sin(2 * np.pi * 0.5 * TIME), False),  # fewer than three oscillations in the second half
        (5.0 * np.exp(-TIME), False),
    ],
)
def test_limit_cycle_is_a_large_fast_oscillation_that_does_not_decay(signal: Array, cycle: bool) -> None:
    assert oscillates_for_good([STILL, signal[:, None]], STILL) == cycle


def test_error_that_repeats_the_motion_of_the_reference_is_no_limit_cycle() -> None:
    lag = 3.0 * np.cos(2 * np.pi * 2 * TIME)[:, None]
    assert oscillates_for_good([lag], STILL)
    assert not oscillates_for_good([lag], np.sin(2 * np.pi * 2 * TIME)[:, None])


def test_episode_has_the_first_kind_of_failure_that_applies() -> None:
    swing = 0.3 * np.sin(2 * np.pi * 3 * TIME)
    assert kind_of(joint_episode(np.zeros(SAMPLES))) == ""
    assert kind_of(joint_episode(np.full(SAMPLES, 0.1))) == "unsettled"
    assert kind_of(joint_episode(swing)) == "limit cycle"
    assert kind_of(joint_episode(swing, diverged=True)) == "diverged"


@pytest.mark.parametrize(("peak", "kind"), [(2.49, ""), (2.51, "excess force")])
def test_force_may_exceed_the_desired_one_by_a_quarter(peak: float, kind: str) -> None:
    force = np.full(SAMPLES, 2.0)
    force[10] = peak
    assert kind_of(press_episode(force)) == kind
    ratio = episode_metrics(press_episode(force))["peak_force_ratio"]
    assert ratio == pytest.approx(50.0 * peak)


def test_bouncing_is_excess_force_before_it_is_a_limit_cycle() -> None:
    bounce = 1.0 + np.sin(2 * np.pi * 4 * TIME)
    assert kind_of(press_episode(bounce)) == "limit cycle"
    assert kind_of(press_episode(2.0 * bounce)) == "excess force"


def test_force_beyond_the_bound_is_excess_force_where_no_force_is_desired() -> None:
    episode = joint_episode(np.zeros(SAMPLES))
    beyond = np.zeros(SAMPLES - 1)
    beyond[3] = 1.0
    info = {**episode.info, "cost_force_bound": beyond}
    assert kind_of(replace(episode, info=info)) == "excess force"


def test_task_without_a_criterion_has_neither_settling_nor_unsettled_episodes() -> None:
    episode = joint_episode(np.full(SAMPLES, 0.1), environment_id="PRP-Unknown-v0")
    assert {"response_settling_time", "unsettled"}.isdisjoint(episode_metrics(episode))
    assert kind_of(episode) == ""
    assert METRICS["failure"].exists(episode)
