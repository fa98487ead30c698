"""Episodes run for their scores alone: what counts, and what ends them."""

import math
from contextlib import closing
from typing import Any

import gymnasium
import numpy as np

from prp_gym.evaluation import evaluate
from prp_gym.tuning import Episodes


class Scripted:
    """A policy with zero torque, but for rows and times at which it does something bad."""

    batched = True

    def __init__(self, bad: dict[int, int], action: float) -> None:
        self.bad, self.action, self.calls = bad, action, 0

    def predict(
        self, observation: Any, state: Any = None, episode_start: Any = None, deterministic: bool = True
    ) -> tuple[Any, Any]:
        action = np.zeros((len(observation), 3), dtype=np.float32)
        for row, first in self.bad.items():
            if self.calls >= first:
                action[row] = self.action
        self.calls += 1
        return action, None


def test_rest_of_an_episode_with_an_action_that_is_not_finite_scores_nothing() -> None:
    env = gymnasium.make("PRP-Compliance-v0", duration=20 / 500.0)
    episodes = Episodes(env, range(3))
    good, bad = episodes.run(Scripted({}, 0.0)), episodes.run(Scripted({1: 5, 2: 0}, math.nan))
    assert good.steps == 60
    assert bad.steps == 20 + 5 + 0
    assert bad.scores[0] == good.scores[0]
    assert 0.0 < bad.scores[1] < good.scores[1]
    assert bad.scores[2] == 0.0
    assert episodes.run(Scripted({}, 0.0)).scores.tolist() == good.scores.tolist()  # nothing is left behind


def test_divergence_ends_an_episode_and_its_steps() -> None:
    with closing(gymnasium.make("PRP-Adaptive-v0", duration=10.0, torque_limit=1e4)) as env:
        episodes = Episodes(env, range(2))
        scores, steps = episodes.run(Full())
        expected = evaluate(Full(), env, 2, 0)
    assert [rollout.diverged for rollout in expected.rollouts] == [True, True]
    assert steps == sum(len(rollout.reward) for rollout in expected.rollouts) < 1000
    # sums in another order
    np.testing.assert_allclose(
        scores, [r.reward.sum() / r.planned_periods for r in expected.rollouts], rtol=1e-12
    )


class Full:
    """Full torque."""

    batched = True

    def predict(
        self, observation: Any, state: Any = None, episode_start: Any = None, deterministic: bool = True
    ) -> tuple[Any, Any]:
        return np.ones((*observation.shape[:-1], 1), dtype=np.float32), None
