"""Scores with intervals, the best controller against the best agent, and aggregates over tasks.

The best of several policies is chosen on the episodes on which it is then compared; intervals do not
account for that choice, which favours the kind that has more policies to choose from.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from prp_gym.comparison.values import AGENT, CONTROLLER, FLOOR, Condition, Entry
from prp_gym.evaluation.hierarchy import bootstrap_crossed, bootstrap_difference, bootstrap_tasks
from prp_gym.evaluation.improvement import paired_probability_of_improvement
from prp_gym.evaluation.profiles import Profile, performance_profile
from prp_gym.evaluation.score_summary import ScoreSummary, failure_of
from prp_gym.evaluation.statistics import Estimate, bootstrap_mean, mean, worst_twentieth
from prp_gym.robot.arrays import Array

UNDECIDED = "-"
"""Verdict where the interval of the paired difference contains 0."""

BEST_CONTROLLER, BEST_AGENT, BEST_FLOOR = "best controller", "best agent", "best floor"
THRESHOLDS = np.linspace(0.0, 1.0, 101)
"""Scores at which performance profiles are taken."""


def estimate_score(entry: Entry, seed: int) -> Estimate:
    """Mean of the score with a 95 % interval.

    The interval is over the episodes, and for agents over the training seeds, too, all of which were
    evaluated on the same episodes.

    Args:
        entry: a policy under a condition.
        seed: random seed of the bootstrap.
    """
    rng = np.random.default_rng(seed)
    if entry.kind == AGENT:
        return bootstrap_crossed(entry.scores, rng, statistic=mean)
    return bootstrap_mean(entry.scores[0], rng)


@lru_cache(maxsize=4096)
def summarise(entry: Entry, seed: int) -> ScoreSummary:
    """Scores of a policy with intervals as in `estimate_score`, and its failed episodes.

    Args:
        entry: a policy under a condition.
        seed: random seed of the bootstrap.
    """
    return ScoreSummary(
        mean=estimate_score(entry, seed),
        interquartile_mean=bootstrap_crossed(entry.scores, np.random.default_rng(seed)),
        worst_twentieth=worst_twentieth(entry.scores),
        failure=failure_of(entry.metrics),
    )


def score_of(entry: Entry) -> float:
    """Mean of all scores."""
    return float(entry.scores.mean())


def best_of(entries: Sequence[Entry]) -> Entry:
    """The policy with the highest score, the first of equal ones."""
    return max(entries, key=score_of)


@dataclass(frozen=True)
class Spread:
    """Scores of agents that differ in their training seed alone.

    Attributes:
        median: median over the training seeds of the mean of each [1].
        low: mean of the worst training seed [1].
        high: mean of the best training seed [1].
    """

    median: float
    low: float
    high: float


def training_spread(entry: Entry) -> Spread:
    """Median and range of the score over the training seeds of an entry."""
    each = mean(entry.scores)
    return Spread(float(np.median(each)), float(each.min()), float(each.max()))


@dataclass(frozen=True)
class PairwiseComparison:
    """The best controller against the best agent under one condition.

    Attributes:
        environment_id: id of the environment.
        scenario: name of the scenario.
        controller: name of the best controller.
        agent: name of the best agent.
        controller_score: score of the controller with its interval [1].
        agent_score: score of the agent with its interval [1].
        difference: score of the agent less that of the controller, paired by evaluation seed [1].
        probability: probability that the agent is better on an evaluation seed, averaged over training seeds
            [1].
    """

    environment_id: str
    scenario: str
    controller: str
    agent: str
    controller_score: Estimate
    agent_score: Estimate
    difference: Estimate
    probability: float

    @property
    def apart(self) -> bool:
        """Whether the intervals of the two scores do not overlap; stricter than the verdict."""
        return (
            self.controller_score.high < self.agent_score.low
            or self.agent_score.high < self.controller_score.low
        )

    @property
    def verdict(self) -> str:
        """`agent` or `controller`, whichever is better; `-` if the paired difference may be 0."""
        if self.difference.low > 0.0:
            return AGENT
        return CONTROLLER if self.difference.high < 0.0 else UNDECIDED


def compare_best(conditions: Iterable[Condition], seed: int) -> list[PairwiseComparison]:
    """The best controller against the best agent, under every condition that has both.

    Args:
        conditions: environments and scenarios with their policies.
        seed: random seed of the bootstrap.
    """
    pairwise_comparisons = []
    for condition in conditions:
        controllers, agents = condition.of_kind(CONTROLLER), condition.of_kind(AGENT)
        if controllers and agents:
            pairwise_comparisons.append(_compare(condition, best_of(controllers), best_of(agents), seed))
    return pairwise_comparisons


def _compare(condition: Condition, controller: Entry, agent: Entry, seed: int) -> PairwiseComparison:
    rng = np.random.default_rng(seed)
    ours = {str(row): scores for row, scores in enumerate(agent.scores)}
    theirs = dict.fromkeys(ours, controller.scores[0])
    return PairwiseComparison(
        condition.environment_id,
        condition.scenario,
        controller.policy,
        agent.policy,
        estimate_score(controller, seed),
        estimate_score(agent, seed),
        bootstrap_difference(agent.scores, controller.scores, rng, statistic=mean),
        # without its interval, which would not include the spread over training seeds
        paired_probability_of_improvement(ours, theirs, rng).value,
    )


@dataclass(frozen=True, eq=False)
class Aggregate:
    """A family of policies on all tasks that it has been trained or tuned for, in one scenario.

    Attributes:
        scenario: name of the scenario.
        family: the best policy of a kind on each task; agents also by action mode.
        tasks: number of tasks.
        score: mean over the tasks of the mean on each.
        reference: score of the best controller, aggregated in the same way over the same tasks.
        profile: share of scores above each threshold, with equal weights of the tasks.
    """

    scenario: str
    family: str
    tasks: int
    score: Estimate
    reference: Estimate
    profile: Profile


def aggregate_tasks(conditions: Sequence[Condition], seed: int) -> list[Aggregate]:
    """Every family of policies over its tasks, in every scenario.

    Args:
        conditions: environments and scenarios with their policies.
        seed: random seed of the bootstrap.
    """
    found = []
    for scenario in dict.fromkeys(condition.scenario for condition in conditions):
        families = _families([condition for condition in conditions if condition.scenario == scenario])
        controllers = families.get(BEST_CONTROLLER, {})
        for family, scores in families.items():
            found.append(
                _aggregate(
                    scenario, family, scores, {k: controllers[k] for k in scores if k in controllers}, seed
                )
            )
    return found


def _families(conditions: Sequence[Condition]) -> dict[str, dict[str, Array]]:
    """Scores (rows, evaluation seeds) of the best policy of each family by environment."""
    families: dict[str, dict[str, Array]] = {}
    for condition in conditions:
        agents = condition.of_kind(AGENT)
        members = {
            BEST_CONTROLLER: condition.of_kind(CONTROLLER),
            BEST_AGENT: agents,
            BEST_FLOOR: condition.of_kind(FLOOR),
        }
        for mode in dict.fromkeys(entry.mode for entry in agents):
            members[f"{AGENT}, {mode}"] = [entry for entry in agents if entry.mode == mode]
        for family, entries in members.items():
            if entries:
                families.setdefault(family, {})[condition.environment_id] = best_of(entries).scores
    return families


def _aggregate(
    scenario: str, family: str, scores: Mapping[str, Array], controllers: Mapping[str, Array], seed: int
) -> Aggregate:
    rng = np.random.default_rng(seed)
    nothing = Estimate(np.nan, np.nan, np.nan)
    return Aggregate(
        scenario,
        family,
        len(scores),
        bootstrap_tasks(scores, rng, statistic=mean),
        bootstrap_tasks(controllers, rng, statistic=mean) if len(controllers) == len(scores) else nothing,
        performance_profile({task: rows.ravel() for task, rows in scores.items()}, THRESHOLDS, rng),
    )
