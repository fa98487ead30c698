"""The environments on which a learned policy can act, and those on which it refuses to."""

from collections.abc import Iterator
from contextlib import closing
from typing import Any

import gymnasium
import pytest
from gymnasium.vector import SyncVectorEnv
from gymnasium.wrappers import FrameStackObservation, RecordEpisodeStatistics, TimeLimit
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import DummyVecEnv, VecFrameStack, VecNormalize

import prp_gym
from prp_gym.agents.policy.learned_policy import LearnedPolicy
from prp_gym.errors import InvalidValueError, UnknownNameError
from tests.support.synthetic_agents import ID, KEYWORDS, layout_of, synthetic_policy

POLICIES = {"without memory": synthetic_policy(), "with memory": synthetic_policy(memory=(5, 4))}


@pytest.fixture(params=POLICIES)
def policy(request: pytest.FixtureRequest) -> LearnedPolicy:
    return POLICIES[request.param]


@pytest.fixture
def env() -> Iterator[gymnasium.Env[Any, Any]]:
    with closing(gymnasium.make(ID, **KEYWORDS)) as made:
        yield made


def test_environment_is_made_as_in_training_unless_told_otherwise(policy: LearnedPolicy) -> None:
    with closing(policy.make_env(scenario="report", duration=0.1)) as env:
        config = env.get_wrapper_attr("config")
        assert (config.scenario, config.duration) == ("report", 0.1)
        assert (config.control_frequency, config.action_mode) == (50, "torque")
    with closing(policy.make_env()) as env:
        assert env.get_wrapper_attr("config").scenario == "realistic"
    policy.environment_keywords["scenario"] = "nothing"
    assert policy.environment_keywords["scenario"] == "realistic"


def test_environment_on_which_it_cannot_act_is_not_made(policy: LearnedPolicy) -> None:
    with pytest.raises(
        InvalidValueError, match=r"control_frequency of the environment is 100.* Hz; allowed: 50"
    ):
        policy.make_env(control_frequency=100)
    with pytest.raises(UnknownNameError, match="no_such"):
        policy.make_env(no_such=1)


@pytest.mark.parametrize(
    "wrap",
    [
        lambda env: env,
        lambda env: env.unwrapped,
        lambda env: TimeLimit(env, 5),
        RecordEpisodeStatistics,
        Monitor,
        lambda env: DummyVecEnv([lambda: env]),
        lambda env: SyncVectorEnv([lambda: env]),
    ],
)
def test_right_environment_is_accepted_in_every_form(policy: LearnedPolicy, env: Any, wrap: Any) -> None:
    policy.check_env(wrap(env))


def test_many_right_environments_are_accepted(policy: LearnedPolicy) -> None:
    for made in (gymnasium.make_vec(ID, 2, **KEYWORDS), prp_gym.make_sb3_vec_env(ID, 2, **KEYWORDS)):
        policy.check_env(made)
        made.close()


WRONG = [
    (ID, {"control_frequency": 25}, "control_frequency of the environment is 25.* Hz; allowed: 50"),
    ("PRP-JointRegulation-v0", {}, f"id of the environment is 'PRP-JointRegulation-v0'; allowed: {ID!r}"),
    ("PRP-Adaptive-v0", {}, "id of the environment is 'PRP-Adaptive-v0'"),
]


@pytest.mark.parametrize(("environment_id", "keywords", "match"), WRONG)
def test_wrong_environment_is_refused_in_every_form(
    policy: LearnedPolicy, environment_id: str, keywords: dict[str, Any], match: str
) -> None:
    keywords = {**KEYWORDS, **keywords}
    forms = (
        gymnasium.make(environment_id, **keywords),
        gymnasium.make_vec(environment_id, 2, **keywords),
        prp_gym.make_sb3_vec_env(environment_id, 2, **keywords),
    )
    for made in forms:
        with pytest.raises(InvalidValueError, match=match):
            policy.check_env(made)
        made.close()


def test_other_layout_action_mode_or_action_size_is_refused(
    policy: LearnedPolicy, env: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    inner = env.unwrapped
    with monkeypatch.context() as patch:
        patch.setattr(inner, "action_space", gymnasium.spaces.Box(-1, 1, (6,)))
        with pytest.raises(
            InvalidValueError, match=r"shape of an action of the environment is \(6,\); allowed: \(3,\)"
        ):
            policy.check_env(inner)
    with monkeypatch.context() as patch:
        patch.setattr(type(inner), "observation_layout", layout_of("PRP-Force-v0"))
        with pytest.raises(
            InvalidValueError, match=r"observation fields of the environment is \(\('joint_position', 3\)"
        ):
            policy.check_env(inner)
    object.__setattr__(inner.config, "action_mode", "impedance")
    with pytest.raises(
        InvalidValueError, match="action_mode of the environment is 'impedance'; allowed: 'torque'"
    ):
        policy.check_env(inner)


@pytest.mark.parametrize(
    ("wrap", "match"),
    [
        (
            lambda env: FrameStackObservation(env, 2),
            r"shape of an observation of the environment is \(2, 27\)",
        ),
        (lambda env: VecFrameStack(DummyVecEnv([lambda: env]), 2), r"shape of an observation .*\(54,\)"),
        (
            lambda env: VecNormalize(DummyVecEnv([lambda: env])),
            "env is 'VecNormalize'; allowed: observations as they",
        ),
    ],
)
def test_wrapper_that_changes_observations_is_refused(
    policy: LearnedPolicy, env: Any, wrap: Any, match: str
) -> None:
    with pytest.raises(InvalidValueError, match=match):
        policy.check_env(wrap(env))


def test_normalised_rewards_alone_are_no_hindrance(policy: LearnedPolicy, env: Any) -> None:
    policy.check_env(VecNormalize(DummyVecEnv([lambda: env]), norm_obs=False))


@pytest.mark.parametrize("foreign", [gymnasium.make("CartPole-v1"), None, "PRP-JointTracking-v0"])
def test_environment_of_another_suite_is_refused(policy: LearnedPolicy, foreign: Any) -> None:
    with pytest.raises(InvalidValueError, match=r"env is .*; allowed: an environment of prp_gym"):
        policy.check_env(foreign)
