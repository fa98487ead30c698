"""Candidates whose episodes run in compiled code: scores and steps are those of the loop, bit for bit."""

import math
from collections.abc import Sequence
from contextlib import closing
from typing import Any

import gymnasium
import numpy as np
import pytest

from prp_gym.baselines import CONTROLLERS, make_baseline
from prp_gym.baselines.joint_pd import JointPDController
from prp_gym.errors import PRPError
from prp_gym.evaluation.rollout import Policy
from prp_gym.tuning import Episodes, SearchSpace, episodes
from prp_gym.tuning.compiled_episodes import run_compiled
from prp_gym.tuning.episodes import EpisodeScores
from tests.support.compiler import needs_compiler
from tests.tuning.test_episodes import Scripted

pytestmark = needs_compiler

SEEDS = range(5, 8)
CASES = [
    ("PRP-JointRegulation-v0", "adaptive", "realistic"),
    ("PRP-JointTracking-v0", "joint_pd", "randomized"),
    ("PRP-PoseTracking-v0", "operational_inverse_dynamics", "report"),
    ("PRP-Force-v0", "parallel_force_position", "realistic"),
    ("PRP-Impedance-v0", "impedance", "randomized"),
    ("PRP-Adaptive-v0", "joint_inverse_dynamics", "realistic"),
]


def made(environment_id: str, scenario: str, **keywords: Any) -> Any:
    return gymnasium.make(environment_id, engine="compiled", scenario=scenario, **keywords)


def candidates(name: str, env: Any, count: int) -> list[Policy]:
    """A controller with its tuned gains, and with others around them, some of which are unstable."""
    spec, rng = CONTROLLERS.find(name), np.random.default_rng(3)
    start = make_baseline(name, env)
    space = SearchSpace.of(spec, start.settings)
    found: list[Policy] = [start]
    while len(found) < count:
        factors = {item.name: float(np.exp(rng.uniform(-2.0, 2.0))) for item in space.parameters}
        try:
            found.append(make_baseline(name, env, **space.settings(factors)))
        except PRPError:  # gains that the controller refuses
            continue
    return found


def looped(env: Any, policies: Sequence[Policy], monkeypatch: pytest.MonkeyPatch) -> list[EpisodeScores]:
    """What the loop gives, which goes through the episodes period by period."""
    with monkeypatch.context() as patch:
        patch.setattr(episodes, "run_compiled", lambda *_: {})
        return Episodes(env, SEEDS).run_all(policies)


def assert_same(found: Sequence[EpisodeScores], expected: Sequence[EpisodeScores]) -> None:
    assert [own.scores.tolist() for own in found] == [own.scores.tolist() for own in expected]
    assert [own.steps for own in found] == [own.steps for own in expected]


def compiled_only(policies: Sequence[Policy], env: Any) -> list[int]:
    """Indices of the policies that compiled code has run."""
    return list(run_compiled(policies, env.unwrapped, env.unwrapped.make_loop, SEEDS))


@pytest.mark.parametrize(("environment_id", "name", "scenario"), CASES)
def test_candidates_have_the_scores_of_the_loop(
    environment_id: str, name: str, scenario: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    with closing(made(environment_id, scenario, duration=0.3)) as env:
        policies = candidates(name, env, 4)
        assert compiled_only(policies, env) == [0, 1, 2, 3]
        expected, own = looped(env, policies, monkeypatch), Episodes(env, SEEDS)
        assert_same(own.run_all(policies), expected)
        assert_same(own.run_all(policies[2:]), expected[2:])  # the same loops, and others
        assert_same(own.run_all(policies), expected)
        assert_same([own.run(policies[1])], expected[1:2])


class Scaled(JointPDController):
    """The packaged controller with a factor on its torques."""

    factor = 1.0

    def torque(self, observed: Any) -> Any:
        return self.factor * super().torque(observed)


def scaled(factor: float, env: Any) -> Any:
    plain = make_baseline("joint_pd", env)
    return type("ScaledByTest", (Scaled,), {"factor": factor})(plain.interface, plain.settings)


def test_divergence_ends_an_episode_and_its_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    with closing(made("PRP-Adaptive-v0", "realistic", duration=4.0, torque_limit=1e4)) as env:
        policies = [scaled(-1e3, env), scaled(1.0, env)]  # the first drives the link away from its reference
        assert compiled_only(policies, env) == [0, 1]
        found = Episodes(env, SEEDS).run_all(policies)
        assert_same(found, looped(env, policies, monkeypatch))
    assert found[0].steps < found[1].steps == 2000 * len(SEEDS)


def test_action_that_is_not_finite_ends_an_episode_as_in_the_loop(monkeypatch: pytest.MonkeyPatch) -> None:
    with closing(made("PRP-JointTracking-v0", "randomized", duration=0.1)) as env:
        policies = [scaled(1.0, env), scaled(math.inf, env)]
        assert compiled_only(policies, env) == [0]
        found = Episodes(env, SEEDS).run_all(policies)
        assert_same(found, looped(env, policies, monkeypatch))
    assert found[1].steps < found[0].steps


def test_policy_that_compiled_code_cannot_run_is_run_by_the_loop(monkeypatch: pytest.MonkeyPatch) -> None:
    with closing(made("PRP-JointTracking-v0", "randomized", duration=0.1)) as env:
        plain: Policy = make_baseline("joint_pd", env)
        policies = [Scripted({1: 5}, 0.5), plain, Scripted({}, 0.0)]
        assert compiled_only(policies, env) == [1]
        found = Episodes(env, SEEDS).run_all(policies)
        again = [Scripted({1: 5}, 0.5), plain, Scripted({}, 0.0)]  # which count their calls
        assert_same(found, looped(env, again, monkeypatch))


def test_mujoco_runs_no_episode_in_compiled_code() -> None:
    with closing(gymnasium.make("PRP-JointTracking-v0", duration=0.1)) as env:
        assert compiled_only([make_baseline("joint_pd", env)], env) == []
