"""Episodes on which candidates are scored, without a recording."""

from collections.abc import Sequence
from functools import cache
from typing import Any, NamedTuple

import gymnasium
import numpy as np
from numpy.typing import NDArray

from prp_gym.evaluation.compiled_batch import begin
from prp_gym.evaluation.policy_output import check_output, takes_batches
from prp_gym.evaluation.rollout import Policy, check_environment
from prp_gym.robot.arrays import Array
from prp_gym.tasks.episode_totals import EpisodeTotals
from prp_gym.tuning.compiled_episodes import run_compiled


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
    They are simulated side by side, those of several policies too, for policies that take several
    observations at once, else one by one. With the compiled engine, whole episodes of a controller of this
    suite run within the compiled code. Whatever runs them, scores and steps are the same.

    Args:
        env: environment of this suite; its wrappers are ignored.
        seeds: seeds of the episodes, at least one.

    Attributes:
        horizon: control periods of an episode that does not end early.

    Raises:
        InvalidValueError: an environment of another suite.
    """

    def __init__(self, env: gymnasium.Env[Any, Any], seeds: Sequence[int]) -> None:
        inner: Any = check_environment(env)
        self._seeds, self._inner = seeds, inner
        self._make_loop = cache(inner.make_loop)
        self.horizon = int(inner.config.horizon)
        self._shape = tuple(inner.action_space.shape)

    @property
    def most_steps(self) -> int:
        """Control steps of all environments together where no episode ends early."""
        return self.horizon * len(self._seeds)

    def run(self, policy: Policy) -> EpisodeScores:
        """The scores of a policy.

        Raises:
            PolicyOutputError: the policy returns something else than actions and a state.
        """
        return self.run_all([policy])[0]

    def run_all(self, policies: Sequence[Policy]) -> list[EpisodeScores]:
        """The scores of several policies; those of each are the same as if it was run alone.

        Raises:
            PolicyOutputError: a policy returns something else than actions and a state.
        """
        compiled = run_compiled(policies, self._inner, self._make_loop, self._seeds)
        others = [policy for index, policy in enumerate(policies) if index not in compiled]
        looped = iter(self._run_others(others))
        return [
            self._totalled(compiled[index]) if index in compiled else next(looped)
            for index in range(len(policies))
        ]

    def _totalled(self, totals: EpisodeTotals) -> EpisodeScores:
        """The scores of episodes that compiled code has run, each to its end or its divergence."""
        steps = np.where(totals.ended > 0, totals.ended, self.horizon)
        return EpisodeScores(totals.reward / self.horizon, int(steps.sum()))

    def _run_others(self, policies: Sequence[Policy]) -> list[EpisodeScores]:
        if policies and all(takes_batches(policy) for policy in policies):
            return self._run(policies, self._seeds)
        return [self._run_one(policy) for policy in policies]

    def _run_one(self, policy: Policy) -> EpisodeScores:
        if takes_batches(policy):
            return self._run([policy], self._seeds)[0]
        parts = [self._run([_OneByOne(policy, self._shape)], [seed])[0] for seed in self._seeds]
        return EpisodeScores(
            np.concatenate([part.scores for part in parts]), sum(part.steps for part in parts)
        )

    def _run(self, policies: Sequence[Policy], seeds: Sequence[int]) -> list[EpisodeScores]:
        """The scores of policies whose episodes are simulated in one loop, those of a policy in a row."""
        size, count = len(seeds), len(seeds) * len(policies)
        loop, _, observation = begin(self._make_loop, [*seeds] * len(policies))
        acting = [_Acting(policy, (size, *self._shape)) for policy in policies]
        returns, steps = np.zeros(count), np.zeros(count, dtype=np.int64)
        alive = np.ones(count, dtype=np.bool_)
        for _ in range(self.horizon):
            parts = zip(
                acting, np.split(observation, len(policies)), np.split(alive, len(policies)), strict=True
            )
            action = np.concatenate([own.act(seen, living) for own, seen, living in parts])
            alive &= np.isfinite(action).all(axis=1)
            if not alive.any():
                break
            step = loop.step(action, None if alive.all() else ~alive)
            returns[alive] += step.reward[alive]
            steps[alive] += 1
            alive &= ~step.terminated
            observation = step.observation
        scores = np.split(returns / self.horizon, len(policies))
        return [
            EpisodeScores(own, int(used.sum()))
            for own, used in zip(scores, np.split(steps, len(policies)), strict=True)
        ]


class _Acting:
    """A policy in its episodes, with its state."""

    def __init__(self, policy: Policy, shape: tuple[int, ...]) -> None:
        self._policy, self._shape = policy, shape
        self._state: Any = None
        self._starts = np.ones(shape[0], dtype=np.bool_)

    def act(self, observation: NDArray[Any], alive: NDArray[np.bool_]) -> Array:
        """The actions (episodes, joints); zeros once all episodes have ended."""
        if not alive.any():
            return np.zeros(self._shape)
        with np.errstate(all="ignore"):  # gains may be so large that torques overflow
            output = self._policy.predict(
                observation, self._state, episode_start=self._starts, deterministic=True
            )
        action, self._state = check_output(self._policy, output, self._shape, finite=False)
        self._starts = np.zeros(self._shape[0], dtype=np.bool_)
        return action.astype(np.float64)


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
