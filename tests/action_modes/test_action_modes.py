"""Action modes: a zero action leaves the inner controller as it is, other actions act as declared."""

import itertools
from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np
import pytest

import prp_gym
from prp_gym.action_modes import RESIDUAL_SHARE, ModeSetup, list_action_modes, make_action_mode
from prp_gym.baselines import BASELINES, make_baseline
from prp_gym.envs import PRPEnv
from prp_gym.errors import InvalidValueError, MissingFieldError, UnknownNameError
from prp_gym.evaluation.batch import record_episodes
from prp_gym.evaluation.rollout import Rollout
from tests.support.mode_episodes import COVERING, KINDS, controller_of, made, random_actions
from tests.support.vector_episodes import assert_same


class Still:
    """A policy whose actions are zero.

    Args:
        size: size of an action.
    """

    def __init__(self, size: int) -> None:
        self._size = size

    def predict(
        self, observation: Any, state: Any = None, episode_start: Any = None, deterministic: bool = True
    ) -> tuple[Any, Any]:
        return np.zeros((*np.shape(observation)[:-1], self._size), dtype=np.float32), None


def idle(env: PRPEnv) -> Still:
    return Still(sum(field.size for field in env.action_fields))


def assert_same_episodes(found: Sequence[Rollout], expected: Sequence[Rollout]) -> None:
    """Compare episodes bit for bit, except for the policy's compute time."""
    assert len(found) == len(expected) > 0
    for ours, theirs in zip(found, expected, strict=True):
        for name in ("seed", "period", "duration", "torque", "applied_torque", "reward", "diverged"):
            assert_same(getattr(ours, name), getattr(theirs, name), name)
        assert_same(dict(ours.fields), dict(theirs.fields), "fields")
        assert_same(dict(ours.info), dict(theirs.info), "info")


@pytest.mark.parametrize(("environment_id", "mode"), COVERING)
def test_zero_action_equals_the_inner_controller_at_500_hz(environment_id: str, mode: str) -> None:
    keywords: dict[str, Any] = {"scenario": "realistic", "duration": 0.04}
    env, plain = (
        made(environment_id, mode, control_frequency=50, **keywords),
        made(environment_id, **keywords),
    )
    expected = record_episodes(make_baseline(controller_of(mode), plain), plain, [0, 1])
    assert len(expected[0].reward) == 20
    assert_same_episodes(record_episodes(idle(env), env, [0, 1]), expected)


AT_RATES = [(*kind, rate) for kind, rate in zip(KINDS, itertools.cycle((20, 500)), strict=False)]
"""Each kind of mode at one of the rates."""


@pytest.mark.parametrize(("environment_id", "mode", "rate"), AT_RATES)
def test_evaluation_with_zero_actions_equals_that_of_the_inner_controller_at_any_rate(
    environment_id: str, mode: str, rate: int
) -> None:
    keywords: dict[str, Any] = {"scenario": "realistic", "duration": 0.2}
    plain = gymnasium.make(environment_id, **keywords)
    env = gymnasium.make(environment_id, action_mode=mode, control_frequency=rate, **keywords)
    expected = prp_gym.evaluate(make_baseline(controller_of(mode), plain), plain, episodes=2, seed=4)
    found = prp_gym.evaluate(Still(env.action_space.shape[0]), env, episodes=2, seed=4)  # type: ignore[index]
    assert_same_episodes(found.rollouts, expected.rollouts)
    assert set(found.metrics) == set(expected.metrics)
    for name, values in expected.metrics.items():
        if not name.startswith("compute"):
            assert_same(found.metrics[name], values, name)


@pytest.mark.parametrize("environment_id", prp_gym.list_envs())
def test_environment_has_the_modes_that_its_observations_serve_and_no_others(environment_id: str) -> None:
    layout = made(environment_id).observation_layout
    possible = set(list_action_modes(layout))
    assert possible <= set(list_action_modes())
    for mode in list_action_modes():
        if mode in possible:
            assert made(environment_id, mode).action_mode == mode
        else:
            assert BASELINES[controller_of(mode)].missing_fields(layout)
            with pytest.raises(MissingFieldError, match=controller_of(mode)):
                made(environment_id, mode)


def test_modes_are_torque_nine_and_a_residual_of_every_controller() -> None:
    modes = list_action_modes()
    assert modes[:10] == [
        "torque",
        "joint_position",
        "joint_inverse_dynamics",
        "operational_position",
        "impedance",
        "variable_stiffness",
        "variable_impedance",
        "admittance",
        "force_position",
        "variable_force_position",
    ]
    residual = [mode for mode in modes if mode.startswith("residual:")]
    assert residual == [f"residual:{controller}" for controller in BASELINES]


def test_unknown_mode_names_the_nearest_one() -> None:
    with pytest.raises(UnknownNameError, match=r"Did you mean 'impedance'\?") as caught:
        made("PRP-Impedance-v0", "impedence")
    assert set(caught.value.valid) == set(list_action_modes())
    with pytest.raises(UnknownNameError, match="residual:joint_pd"):
        made("PRP-Impedance-v0", "residual:jont_pd")
    with pytest.raises(UnknownNameError, match="unknown action_mode None"):
        gymnasium.make("PRP-Impedance-v0", action_mode=None)


def test_torque_has_no_inner_controller() -> None:
    env = made("PRP-Impedance-v0")
    with pytest.raises(UnknownNameError, match="unknown action_mode 'torque'"):
        make_action_mode("torque", ModeSetup(env.task, env.torque_limit, 0.002))


@pytest.mark.parametrize("rate", [1000, 40])
def test_rate_that_does_not_divide_the_controller_s_is_refused_with_the_reason(rate: int) -> None:
    with pytest.raises(InvalidValueError, match="divisor of 500, the frequency inside mode 'impedance'"):
        made("PRP-Impedance-v0", "impedance", control_frequency=rate)
    assert made("PRP-Impedance-v0", control_frequency=rate).control_frequency == rate


def test_duration_is_a_whole_number_of_actions() -> None:
    with pytest.raises(InvalidValueError, match=r"control periods of 0\.02 s"):
        made("PRP-Impedance-v0", "impedance", control_frequency=50, duration=0.05)


def test_controller_is_refused_where_actions_are_not_torques() -> None:
    env = made("PRP-Impedance-v0", "impedance")
    with pytest.raises(InvalidValueError, match="action_mode is 'impedance'; allowed: 'torque'"):
        make_baseline("impedance", env)
    with pytest.raises(InvalidValueError, match="'torque'"):
        make_baseline("impedance", gymnasium.make_vec("PRP-Impedance-v0", 2, action_mode="impedance"))


@pytest.mark.parametrize(
    ("environment_id", "mode"), [each for each in COVERING if each[1].startswith("residual")]
)
def test_residual_adds_its_share_of_the_limits(environment_id: str, mode: str) -> None:
    env, plain = made(environment_id, mode), made(environment_id)
    observation, _ = env.reset(seed=3)
    controller, _ = make_baseline(controller_of(mode), plain).predict(observation)
    action = random_actions(env, 1)[0]
    env.step(action)
    wanted = controller.astype(np.float64) + RESIDUAL_SHARE * action.astype(np.float64)
    # a share of the limit and back, at most two roundings
    np.testing.assert_allclose(
        env.commanded_torque, np.clip(wanted, -1.0, 1.0) * env.torque_limit, rtol=1e-14
    )


@pytest.mark.parametrize(
    ("keywords", "share"),
    [
        ({"scenario": "report"}, 0.2),
        ({"torque_limit": None}, 0.2),
        ({"torque_limit": (5.0, 10.0, 1.0)}, 0.02),
    ],
)
def test_residual_is_never_more_than_a_share_of_the_robots_own_limits(
    keywords: dict[str, Any], share: float
) -> None:
    env = made("PRP-JointTracking-v0", "residual:joint_pd", **keywords)
    (field,) = env.action_fields
    np.testing.assert_allclose(field.bound, share * np.array([50.0, 100.0, 10.0]), rtol=1e-15)  # one product
    env.reset(seed=0)
    still = made("PRP-JointTracking-v0", "residual:joint_pd", **keywords)
    still.reset(seed=0)
    env.step(np.ones(3))
    still.step(np.zeros(3))
    added = env.commanded_torque - still.commanded_torque
    # the controller's torque, a float32 share of a limit up to 1e6, is equal in both: the difference is exact
    np.testing.assert_allclose(added, field.bound, rtol=1e-9)


def test_same_seeds_give_the_same_bits() -> None:
    episodes = []
    for _ in range(2):
        env = made("PRP-ForcePosition-v0", "force_position", scenario="realistic", control_frequency=50)
        start = env.reset(seed=42)
        episodes.append((start, [env.step(action) for action in random_actions(env, 20)]))
    assert_same(episodes[1], episodes[0], "episode")
