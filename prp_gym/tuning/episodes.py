"""Episodes that one candidate after the other plays, for their scores alone."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import gymnasium
import numpy as np
from gymnasium.utils import seeding

from prp_gym.evaluation.rollout import Policy, check_environment
from prp_gym.robot.arrays import Array


class EpisodeScores(NamedTuple):
    """What episodes came to.

    Attributes:
        scores: return over duration (episodes) [1].
        steps: that were simulated, of all environments together.
    """

    scores: Array
    steps: int


class Episodes:
    """The same episodes for every policy, one a seed, played side by side and not recorded.

    They are those that `prp_gym.evaluate` plays with these seeds, and so are their scores. An episode ends
    with a divergence, or where a policy's action is not finite; the rest of it scores 0 and is not simulated.

    Args:
        env: an environment of this suite; wrappers are passed over.
        seeds: of the episodes, at least one.

    Raises:
        InvalidValueError: an environment of another suite.
    """

    def __init__(self, env: gymnasium.Env[Any, Any], seeds: Sequence[int]) -> None:
        inner: Any = check_environment(env)
        self._seeds = seeds
        self._loop = inner.make_loop(len(seeds))
        self._horizon = int(inner.config.horizon)
        self._duration = float(inner.duration)

    @property
    def most_steps(self) -> int:
        """Steps of all environments together where no episode ends early."""
        return self._horizon * len(self._seeds)

    def play(self, policy: Policy) -> EpisodeScores:
        """The scores of a policy."""
        count = len(self._seeds)
        rngs = [seeding.np_random(int(seed))[0] for seed in self._seeds]
        observation = self._loop.reset(np.arange(count), rngs, {})
        returns, alive, steps = np.zeros(count), np.ones(count, dtype=np.bool_), 0
        state, starts = None, np.ones(count, dtype=np.bool_)
        for _ in range(self._horizon):
            with np.errstate(all="ignore"):  # gains may be so large that torques overflow
                action, state = policy.predict(observation, state, episode_start=starts, deterministic=True)
            starts = np.zeros(count, dtype=np.bool_)
            alive &= np.isfinite(action).all(axis=1)
            if not alive.any():
                break
            step = self._loop.step(action.astype(np.float64), None if alive.all() else ~alive)
            returns[alive] += step.reward[alive]
            steps += int(np.count_nonzero(alive))
            alive &= ~step.terminated
            observation = step.observation
        return EpisodeScores(returns / self._duration, steps)
