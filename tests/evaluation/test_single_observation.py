"""Policies that take one observation at a time, and what they must return."""

import pickle
from typing import Any

import gymnasium
import numpy as np
import pytest

from prp_gym import evaluate
from prp_gym.baselines import CONTROLLERS, make_baseline
from prp_gym.errors import InvalidValueError, PolicyOutputError
from prp_gym.evaluation.policy_output import takes_batches
from prp_gym.tuning import Episodes

ID = "PRP-JointTracking-v0"
JOINTS = 3


@pytest.fixture
def env() -> Any:
    made = gymnasium.make(ID, scenario="randomized", duration=0.04)
    yield made
    made.close()


class Single:
    """A controller for one observation that keeps a count of its own, as no batched policy may."""

    def __init__(self, policy: Any) -> None:
        self.policy = policy
        self.steps = 0
        self.longest = 0

    def predict(
        self, observation: Any, state: Any = None, episode_start: Any = None, deterministic: bool = True
    ) -> tuple[Any, Any]:
        assert observation.ndim == 1
        self.steps = 1 if episode_start[0] else self.steps + 1
        self.longest = max(self.longest, self.steps)
        action, after = self.policy.predict(observation, state, episode_start, deterministic)
        return action, after


def test_policy_for_one_observation_scores_as_the_same_one_for_several(env: Any) -> None:
    batched, single = make_baseline("joint_pd", env), Single(make_baseline("joint_pd", env))
    expected = evaluate(batched, env, episodes=3, seed=4)
    found = evaluate(single, env, episodes=3, seed=4)
    np.testing.assert_array_equal(found.metrics["score"], expected.metrics["score"])
    assert single.longest == 20  # one episode after the other


def test_tuning_episodes_of_one_observation_score_as_several(env: Any) -> None:
    batched, single = make_baseline("adaptive", env), Single(make_baseline("adaptive", env))
    episodes = Episodes(env, range(3, 6))
    expected, found = episodes.run(batched), episodes.run(single)
    np.testing.assert_array_equal(found.scores, expected.scores)
    assert found.steps == expected.steps == 60
    assert single.longest == 20


def test_declaration_of_a_controller_is_made_for_the_environment(env: Any) -> None:
    found = evaluate(CONTROLLERS["joint_pd"], env, episodes=2)
    expected = evaluate(make_baseline("joint_pd", env), env, episodes=2)
    np.testing.assert_array_equal(found.metrics["score"], expected.metrics["score"])


class BaseAlgorithm:
    __module__ = "stable_baselines3.common.base_class"


class OfTheLibrary(BaseAlgorithm):
    __module__ = "sb3_contrib.ppo_recurrent"


class Homonym:
    """A class of another library with the same name."""


Homonym.__name__ = "BaseAlgorithm"


class Batched:
    batched = True


class SaysNo(OfTheLibrary):
    batched = False


@pytest.mark.parametrize(
    ("policy", "expected"),
    [(OfTheLibrary(), True), (Homonym(), False), (Batched(), True), (SaysNo(), False), (object(), False)],
)
def test_batches_are_taken_by_policies_that_say_so_and_by_the_library_s(policy: Any, expected: bool) -> None:
    assert takes_batches(policy) == expected


def test_policies_of_the_suite_take_batches(env: Any) -> None:
    assert all(takes_batches(spec.policy) for spec in CONTROLLERS.values())


class Returns:
    """A policy that returns one thing."""

    def __init__(self, output: Any, batched: bool = False) -> None:
        self.output, self.batched = output, batched

    def predict(self, *_: Any, **__: Any) -> Any:
        return self.output


WRONG = {
    "no state": (np.zeros(JOINTS), "a ndarray, not two values"),
    "nothing": (None, "a NoneType, not two values"),
    "too short": ((np.zeros(JOINTS - 1), None), r"an action of shape \(2,\)"),
    "column": ((np.zeros((1, JOINTS)), None), r"an action of shape \(1, 3\)"),
    "number": ((0.5, None), r"an action of shape \(\)"),
    "words": (("full", None), "an action that holds no numbers: 'full'"),
    "ragged": (([[1.0], [2.0, 3.0]], None), "an action that holds no numbers"),
    "not finite": (
        (np.array([0.0, np.nan, 0.0]), None),
        r"an action with NaN or infinity: \[0.0, nan",
    ),
    "infinite": ((np.full(JOINTS, np.inf), None), r"an action with NaN or infinity: \[inf, inf, inf\]"),
}


@pytest.mark.parametrize("case", WRONG)
@pytest.mark.parametrize("episodes", [1, 2])
def test_wrong_output_is_refused_with_what_must_be_returned(env: Any, case: str, episodes: int) -> None:
    output, found = WRONG[case]
    with pytest.raises(PolicyOutputError, match=f"predict of Returns returned {found}") as caught:
        evaluate(Returns(output), env, episodes=episodes)
    message = str(pickle.loads(pickle.dumps(caught.value)))
    assert "it must return (action, state) with finite actions of shape (3,) for one observation" in message
    assert "`batched = True`" in message


def test_wrong_output_of_a_batched_policy_is_refused(env: Any) -> None:
    policy = Returns((np.zeros(JOINTS), None), batched=True)
    with pytest.raises(PolicyOutputError, match=r"of shape \(3,\) for observations of shape \(2, 'size'\)"):
        evaluate(policy, env, episodes=2)


def test_what_is_no_policy_is_refused(env: Any) -> None:
    with pytest.raises(InvalidValueError, match="allowed: an object with `predict`, or the declaration"):
        evaluate(3, env)  # type: ignore[arg-type]
