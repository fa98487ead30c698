"""Episodes on which candidates are scored, without a recording."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import gymnasium
import numpy as np
from gymnasium.utils import seeding
from numpy.typing import NDArray

from prp_gym.evaluation.policy_output import check_output, takes_batches
from prp_gym.evaluation.rollout import Policy, check_environment
from prp_gym.robot.arrays import Array


class EpisodeScores(NamedTuple):
    """Scores of some episodes, and their cost.

    Attributes:
        scores: mean reward over the planned steps (episodes) [1].
        steps: control steps that were simulated, of all environments together.
    """

    scores: Array
    steps: int


class Episodes:
    """The same episodes for every policy, one for each seed, which are not recorded.

    They are those that `prp_gym.evaluate` runs with these seeds, and so are their scores. An episode ends
    with a divergence, or where a policy's action is not finite; the rest of it scores 0 and is not simulated.
    They are simulated side by side for a policy that takes several observations at once, else one by one.

    Args:
        env: environment of this suite; its wrappers are ignored.
        seeds: seeds of the episodes, at least one.

    Raises:
        InvalidValueError: an environment of another suite.
    """

    def __init__(self, env: gymnasium.Env[Any, Any], seeds: Sequence[int]) -> None:
        inner: Any = check_environment(env)
        self._seeds = seeds
        self._loops = {len(seeds): inner.make_loop(len(seeds)), 1: inner.make_loop(1)}
        self._horizon = int(inner.config.horizon)
        self._shape = tuple(inner.action_space.shape)

    @property
    def most_steps(self) -> int:
        """Control steps of all environments together where no episode ends early."""
        return self._horizon * len(self._seeds)

    def run(self, policy: Policy) -> EpisodeScores:
        """The scores of a policy.

        Raises:
            PolicyOutputError: the policy returns something else than actions and a state.
        """
        if takes_batches(policy):
            return self._run(policy, self._seeds)
        parts = [self._run(_OneByOne(policy, self._shape), [seed]) for seed in self._seeds]
        return EpisodeScores(
            np.concatenate([part.scores for part in parts]), sum(part.steps for part in parts)
        )

    def _run(self, policy: Policy, seeds: Sequence[int]) -> EpisodeScores:
        count, loop = len(seeds), self._loops[len(seeds)]
        rngs = [seeding.np_random(int(seed))[0] for seed in seeds]
        observation = loop.reset(np.arange(count), rngs, {})
        returns, alive, steps = np.zeros(count), np.ones(count, dtype=np.bool_), 0
        state, starts = None, np.ones(count, dtype=np.bool_)
        for _ in range(self._horizon):
            with np.errstate(all="ignore"):  # gains may be so large that torques overflow
                output = policy.predict(observation, state, episode_start=starts, deterministic=True)
            action, state = check_output(policy, output, (count, *self._shape), finite=False)
            starts = np.zeros(count, dtype=np.bool_)
            alive &= np.isfinite(action).all(axis=1)
            if not alive.any():
                break
            step = loop.step(action.astype(np.float64), None if alive.all() else ~alive)
            returns[alive] += step.reward[alive]
            steps += int(np.count_nonzero(alive))
            alive &= ~step.terminated
            observation = step.observation
        return EpisodeScores(returns / self._horizon, steps)


class _OneByOne:
    """Adapter that gives a policy for single observations a batch of one observation."""

    def __init__(self, policy: Policy, shape: tuple[int, ...]) -> None:
        self._policy, self._shape = policy, shape

    def predict(
        self,
        observation: NDArray[Any],
        state: Any = None,
        episode_start: NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[NDArray[Any], Any]:
        """The action (1, joints) for an observation (1, size)."""
        output = self._policy.predict(observation[0], state, episode_start, deterministic)
        action, after = check_output(self._policy, output, self._shape, finite=False)
        return action[None], after
