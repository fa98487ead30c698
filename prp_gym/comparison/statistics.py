"""Who is better: scores with intervals, the best law against the best agent, and all tasks together.

The best of several policies is chosen on the episodes on which it is then compared; intervals do not
account for that choice, which favours the side that has more policies to choose from.
"""

import itertools
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from prp_gym.comparison.values import AGENT, BUDGET, CLASSICAL, CONTROLLER, Condition, Entry
from prp_gym.evaluation.hierarchy import bootstrap_crossed, bootstrap_difference, bootstrap_tasks
from prp_gym.evaluation.improvement import paired_probability_of_improvement
from prp_gym.evaluation.profiles import Profile, performance_profile
from prp_gym.evaluation.statistics import Estimate, bootstrap_interquartile_mean, interquartile_mean
from prp_gym.robot.arrays import Array

UNDECIDED = "-"
BEST_LAW, BEST_BUDGET_LAW, BEST_AGENT = "best law", "best equal-budget law", "best agent"
THRESHOLDS = np.linspace(0.0, 1.0, 101)
"""Scores at which performance profiles are taken."""


def estimate_score(entry: Entry, seed: int) -> Estimate:
    """Interquartile mean of the score with a 95 % interval.

    The interval is over episodes, and for agents over training seeds, too; these met the same episodes.

    Args:
        entry: a policy at a place.
        seed: of the bootstrap.
    """
    rng = np.random.default_rng(seed)
    if entry.kind == AGENT:
        return bootstrap_crossed(entry.scores, rng)
    return bootstrap_interquartile_mean(entry.scores[0], rng)


def score_of(entry: Entry) -> float:
    """Interquartile mean of all scores."""
    return float(interquartile_mean(entry.scores.ravel()))


def best_of(entries: Sequence[Entry]) -> Entry:
    """The policy with the highest score; of equal ones the first."""
    return max(entries, key=score_of)


@dataclass(frozen=True)
class Spread:
    """Scores of agents that differ in their training seed alone.

    Attributes:
        median: over the training seeds, of each one's interquartile mean [1].
        low: the worst training seed [1].
        high: the best training seed [1].
    """

    median: float
    low: float
    high: float


def training_spread(entry: Entry) -> Spread:
    """Median and range over the rows of an entry."""
    each = interquartile_mean(entry.scores)
    return Spread(float(np.median(each)), float(each.min()), float(each.max()))


@dataclass(frozen=True)
class PairwiseComparison:
    """The best law against the best agent at a place.

    Attributes:
        environment_id: of the place.
        scenario: of the place.
        controller: name of the best law of its kind.
        agent: name of the best agent.
        controller_score: its score.
        agent_score: its score.
        difference: agent less law, paired on the evaluation seeds [1].
        probability: that the agent is better on an evaluation seed, averaged over training seeds.
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
        """`agent` or `controller` where the interval of the paired difference leaves out 0, else `-`."""
        if self.difference.low > 0.0:
            return AGENT
        return CONTROLLER if self.difference.high < 0.0 else UNDECIDED


def compare_best(conditions: Iterable[Condition], seed: int) -> list[PairwiseComparison]:
    """The best law of either kind against the best agent, at each place that has both.

    A law with its own gains had as much tuning as its author gave it; one that was tuned with a budget had as
    much as an agent.

    Args:
        conditions: with their policies.
        seed: of the bootstrap.
    """
    pairwise_comparisons = []
    for place, kind in itertools.product(conditions, CLASSICAL):
        controllers, agents = place.of_kind(kind), place.of_kind(AGENT)
        if controllers and agents:
            pairwise_comparisons.append(_compare(place, best_of(controllers), best_of(agents), seed))
    return pairwise_comparisons


def _compare(place: Condition, controller: Entry, agent: Entry, seed: int) -> PairwiseComparison:
    rng = np.random.default_rng(seed)
    ours = {str(row): scores for row, scores in enumerate(agent.scores)}
    theirs = dict.fromkeys(ours, controller.scores[0])
    return PairwiseComparison(
        place.environment_id,
        place.scenario,
        controller.policy,
        agent.policy,
        estimate_score(controller, seed),
        estimate_score(agent, seed),
        bootstrap_difference(agent.scores, controller.scores, rng),
        # its interval is left out: it would know nothing of training seeds
        paired_probability_of_improvement(ours, theirs, rng).value,
    )


@dataclass(frozen=True, eq=False)
class Aggregate:
    """A family of policies on all tasks that it has been trained or tuned for, in one scenario.

    Attributes:
        scenario: of the environments.
        family: the best law or agent of a kind on each task; agents also by what an action means.
        tasks: how many.
        score: interquartile mean over the tasks of the interquartile mean on each.
        reference: the same of the best law on the same tasks.
        profile: share of scores above each threshold, each task weighing the same.
    """

    scenario: str
    family: str
    tasks: int
    score: Estimate
    reference: Estimate
    profile: Profile


def aggregate_tasks(conditions: Sequence[Condition], seed: int) -> list[Aggregate]:
    """Every family in every scenario over its tasks.

    Args:
        conditions: with their policies.
        seed: of the bootstrap.
    """
    found = []
    for scenario in dict.fromkeys(place.scenario for place in conditions):
        families = _families([place for place in conditions if place.scenario == scenario])
        controllers = families.get(BEST_LAW, {})
        for family, scores in families.items():
            found.append(
                _aggregate(
                    scenario, family, scores, {k: controllers[k] for k in scores if k in controllers}, seed
                )
            )
    return found


def _families(conditions: Sequence[Condition]) -> dict[str, dict[str, Array]]:
    """Scores (rows, evaluation seeds) of the best of each family by environment."""
    families: dict[str, dict[str, Array]] = {}
    for place in conditions:
        agents = place.of_kind(AGENT)
        members = {
            BEST_LAW: place.of_kind(CONTROLLER),
            BEST_BUDGET_LAW: place.of_kind(BUDGET),
            BEST_AGENT: agents,
        }
        for mode in dict.fromkeys(entry.mode for entry in agents):
            members[f"{AGENT}, {mode}"] = [entry for entry in agents if entry.mode == mode]
        for family, entries in members.items():
            if entries:
                families.setdefault(family, {})[place.environment_id] = best_of(entries).scores
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
        bootstrap_tasks(scores, rng),
        bootstrap_tasks(controllers, rng) if len(controllers) == len(scores) else nothing,
        performance_profile({task: rows.ravel() for task, rows in scores.items()}, THRESHOLDS, rng),
    )
