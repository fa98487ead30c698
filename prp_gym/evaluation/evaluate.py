"""`evaluate`: a policy on an environment over several episodes."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

import gymnasium
import numpy as np

from prp_gym.checks import random_seed, whole
from prp_gym.errors import InvalidValueError
from prp_gym.evaluation.batch import can_batch, record_episodes
from prp_gym.evaluation.compiled_batch import record_compiled
from prp_gym.evaluation.episode import record_episode
from prp_gym.evaluation.failure import FAILURES
from prp_gym.evaluation.metrics import METRICS, episode_metrics
from prp_gym.evaluation.policy_output import takes_batches
from prp_gym.evaluation.rollout import Policy, Rollout, condition_name
from prp_gym.evaluation.score_summary import ScoreSummary
from prp_gym.evaluation.statistics import Estimate
from prp_gym.evaluation.summary_table import summary_table
from prp_gym.robot.arrays import Array
from prp_gym.tables import ResultTable
from prp_gym.tables.data_frame import make_frame

if TYPE_CHECKING:
    from prp_gym.figures.notebook_figure import NotebookFigure
    from prp_gym.tables.data_frame import DataFrame

_MOST_EPISODES = 10**6


@runtime_checkable
class Makeable(Protocol):
    """The declaration of a policy, from which one is made for an environment."""

    def make(self, env: gymnasium.Env[Any, Any]) -> Policy:
        """The policy for an environment."""


@dataclass(frozen=True, eq=False, repr=False)
class Evaluation:
    """Recorded episodes of one policy on one environment.

    Attributes:
        rollouts: recorded episodes, in the order of their seeds.
        seed: random seed of the first episode; it also seeds the bootstrap.
    """

    rollouts: Sequence[Rollout]
    seed: int

    def __repr__(self) -> str:
        """The environment, the number of episodes, the score and the failed episodes."""
        first, summary = self.rollouts[0], self.summary
        low, high = summary.mean.low, summary.mean.high
        failed = ", ".join(
            f"{share:.0f} % {kind}" for kind, share in zip(FAILURES, summary.failure, strict=True) if share
        )
        return (
            f"<Evaluation of {len(self.rollouts)} episodes of {first.environment_id}, scenario"
            f" {first.scenario}: score {summary.mean.value:.3f} ({low:.3f}-{high:.3f}), worst twentieth"
            f" {summary.worst_twentieth:.3f}, failed: {failed or 'none'}>"
        )

    @cached_property
    def metrics(self) -> dict[str, Array]:
        """Metrics by name, (episodes, components); units in `prp_gym.evaluation.METRICS`."""
        rows = [episode_metrics(rollout) for rollout in self.rollouts]
        return {name: np.stack([row[name] for row in rows]) for name in rows[0]}

    @cached_property
    def summary(self) -> ScoreSummary:
        """Mean, interquartile mean and worst twentieth of the score, and the failures by kind."""
        return ScoreSummary.of(self.metrics, self.seed)

    @property
    def score(self) -> Estimate:
        """Mean of the score with a 95 % bootstrap interval."""
        return self.summary.mean

    @cached_property
    def median(self) -> dict[str, Array]:
        """Median over the episodes of every metric, (components); NaN where no episode has one."""
        return {name: _median(values) for name, values in self.metrics.items()}

    @property
    def compute_time(self) -> float:
        """Median time that the policy took for an action [s]."""
        return float(np.median(np.concatenate([rollout.compute_time for rollout in self.rollouts])))

    @property
    def table(self) -> ResultTable:
        """Score, failures, and medians of the metrics that the task shows."""
        first = self.rollouts[0]
        condition = condition_name(first.environment_id, first.scenario, first.engine)
        title = f"{len(self.rollouts)} episodes of {condition}"
        return summary_table(title, first.environment_id, self.summary, self.median)

    def _repr_html_(self) -> str:
        """The table for a notebook."""
        return self.table._repr_html_()

    def to_frame(self) -> "DataFrame":
        """The metrics as a data frame of pandas, a row for each episode.

        Returns:
            the seeds, and every metric by name, with `_1`, `_2`, ... for several components; units stand in
            `attrs["units"]`.

        Raises:
            MissingPackageError: pandas is not installed.
        """
        seeds = np.array([rollout.seed for rollout in self.rollouts])
        units = {name: METRICS.find(name).units for name in self.metrics}
        return make_frame({"seed": seeds, **self.metrics}, units)

    def plot(self, episode: int = 0, policy: str = "") -> "NotebookFigure":
        """One episode as a figure: motion, errors, torques, contact force and reward.

        Args:
            episode: number of the episode, from 0.
            policy: name of the policy for the title; empty to leave it out.

        Raises:
            InvalidValueError: an episode that there is not.
        """
        return self.rollouts[whole("episode", episode, 0, len(self.rollouts) - 1)].plot(policy)


def _median(values: Array) -> Array:
    """Median over the first axis of the values that are not NaN."""
    kept = [column[~np.isnan(column)] for column in values.T]
    return np.array([np.median(column) if len(column) else np.nan for column in kept])


def evaluate(
    policy: Policy | Makeable,
    env: gymnasium.Env[Any, Any],
    episodes: int = 20,
    seed: int = 0,
    on_episode: Callable[[], None] = lambda: None,
) -> Evaluation:
    """Run and record episodes with the seeds seed, seed + 1, ...

    Equal seeds give every policy the same episodes, so that results can be compared episode by episode. A
    deterministic scenario is run once, since further episodes would be identical.

    The episodes are simulated side by side if the policy takes several observations at once, as those of this
    suite and of Stable-Baselines3 do, and if no wrapper changes what it observes or does. Any other policy
    gets one observation at a time, episode after episode, unless it has the attribute `batched = True`.

    Args:
        policy: policy with Stable-Baselines3's `predict`, or the declaration of a controller, which is made
            for the environment with its tuned gains.
        env: an environment of this suite.
        episodes: number of episodes.
        seed: random seed of the first episode.
        on_episode: function that is called after each episode, for progress bars.

    Returns:
        the recorded episodes with their metrics.

    Raises:
        InvalidValueError: fewer than one episode, a negative seed, an environment of another suite.
        PolicyOutputError: the policy returns something else than finite actions and a state.
    """
    check_protocol(episodes, seed)
    count = episodes_to_run(env, episodes)
    chosen = _policy(policy, env)
    seeds = [int(seed) + index for index in range(count)]
    if takes_batches(chosen) and can_batch(env):
        together = record_episodes if count > 1 else record_compiled
        found = together(chosen, env.unwrapped, seeds)
        if found is not None:
            for _ in seeds:
                on_episode()
            return Evaluation(found, int(seed))
    rollouts = []
    for own in seeds:
        rollouts.append(record_episode(chosen, env, own))
        on_episode()
    return Evaluation(rollouts, int(seed))


def _policy(given: Any, env: gymnasium.Env[Any, Any]) -> Policy:
    """A policy itself, or the one that a declaration makes for an environment.

    Raises:
        InvalidValueError: neither of the two.
    """
    if isinstance(given, Policy):
        return given
    if not isinstance(given, Makeable):
        allowed = "an object with `predict`, or the declaration of a controller"
        raise InvalidValueError("policy", given, allowed)
    made: Policy = given.make(env)
    return made


def check_protocol(episodes: int, seed: int) -> None:
    """Refuse a number of episodes or a first seed that is not allowed.

    Raises:
        InvalidValueError: fewer than one episode, a negative seed, a number that is not whole.
    """
    whole("episodes", episodes, 1, _MOST_EPISODES)
    random_seed("seed", seed)


def episodes_to_run(env: gymnasium.Env[Any, Any], episodes: int) -> int:
    """1 where every episode is the same, else the requested number."""
    task = getattr(getattr(env, "unwrapped", None), "task", None)
    if task is None:
        raise InvalidValueError("env", env, "an environment of prp_gym")
    return 1 if task.scenario.deterministic else episodes
