"""`Objective`: what a search maximises, the mean score of a candidate over episodes of several scenarios."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, NamedTuple

import gymnasium
import numpy as np

from prp_gym.errors import PRPError
from prp_gym.evaluation.evaluate import episodes_to_run
from prp_gym.robot.arrays import Array
from prp_gym.tuning.candidates import Candidates
from prp_gym.tuning.episodes import Episodes
from prp_gym.tuning.trial import Trial

HOPELESS = 1.25
"""A candidate that loses more than this times what the best one loses, in the same scenarios, is stopped."""

Settings = Mapping[str, Any]

EpisodeRows = Sequence[Sequence[float]]
"""Scores of one policy, by scenario and episode [1]."""


class ScenarioCandidates(NamedTuple):
    """The candidates of a search in one scenario.

    Attributes:
        env: environment of the scenario.
        candidates: candidates that are made for the environment.
    """

    env: gymnasium.Env[Any, Any]
    candidates: Candidates


class CandidateScore(NamedTuple):
    """What running a candidate gave.

    Attributes:
        score: mean over the scenarios of the mean score [1]; an estimate where the candidate was stopped.
        steps: control steps that it uses of the budget.
        by_scenario: mean score over the episodes of each scenario that was run [1].
        stopped: whether scenarios were left out.
        slopes: derivatives of the score, see `Trial`.
    """

    score: float
    steps: int
    by_scenario: tuple[float, ...]
    stopped: bool
    slopes: Mapping[str, float] = MappingProxyType({})


class ScenarioRun(NamedTuple):
    """The episodes of a search in one scenario.

    Attributes:
        env: environment of the scenario.
        candidates: candidates that are made for the environment.
        seeds: seeds of the episodes.
        episodes: the episodes.
    """

    env: gymnasium.Env[Any, Any]
    candidates: Candidates
    seeds: range
    episodes: Episodes


class Objective:
    """Mean over scenarios of a candidate's mean score; all candidates have the same episodes.

    Scenarios have equal weights and episodes of their own. They are run one after the other: what a candidate
    loses, 1 less its score, is compared with what the best one has lost in the same scenarios, and if it is
    more than `HOPELESS` times that, the other scenarios are left out. Its score is then estimated as that of
    the best one less the mean difference in the scenarios that were run; it is always below the best one's.

    Args:
        conditions: the scenarios with their candidates, at least one.
        first_seed: seed of the first episode.
        episodes: number of episodes, which are divided evenly among the scenarios and rounded up; a
            deterministic scenario has one.

    Attributes:
        episodes: number of episodes of a candidate.
        runs: the episodes of each scenario.
    """

    def __init__(self, conditions: Sequence[ScenarioCandidates], first_seed: int, episodes: int) -> None:
        each = -(-episodes // len(conditions))
        self.runs: list[ScenarioRun] = []
        self.episodes = 0
        for env, candidates in conditions:
            first = first_seed + self.episodes
            count = episodes_to_run(env, each)
            seeds = range(first, first + count)
            self.runs.append(ScenarioRun(env, candidates, seeds, Episodes(env, seeds)))
            self.episodes += count

    @property
    def most_steps(self) -> int:
        """Control steps of a candidate of which no episode ends early."""
        return sum(run.episodes.most_steps for run in self.runs)

    def measure(self, proposals: Sequence[Mapping[str, float]], best: Trial | None) -> list[CandidateScore]:
        """Run candidates side by side, each to its end or until it is hopeless.

        A candidate that the controller refuses scores 0 and uses as much of the budget as a whole one.

        Args:
            proposals: factors of the search space for each candidate, by the names of its parameters.
            best: the best trial before these, if there is one.

        Returns:
            one for each candidate, the same as if it was run alone.
        """
        found: dict[int, CandidateScore] = {}
        running = [_Running(number) for number in range(len(proposals))]
        for _, candidates, _, episodes in self.runs:
            policies = []
            for item in list(running):
                try:
                    policies.append(candidates.make(proposals[item.number]))
                except PRPError:
                    found[item.number] = CandidateScore(0.0, self.most_steps, (0.0,) * len(self.runs), False)
                    running.remove(item)
            for item, outcome in zip(running, episodes.run_all(policies) if policies else [], strict=True):
                item.means.append(_episode_mean(outcome.scores))
                item.steps += outcome.steps
            for item in list(running):
                whole = len(item.means) == len(self.runs)
                if whole or (best is not None and _is_hopeless(item.means, best.by_scenario)):
                    found[item.number] = item.measured(None if whole else best)
                    running.remove(item)
        return [found[number] for number in range(len(proposals))]

    def episode_scores(self, settings_of: Sequence[Callable[[Candidates], Settings]]) -> list[EpisodeRows]:
        """Scores of given settings on all episodes of all scenarios.

        Args:
            settings_of: functions that give accepted settings from the candidates of a scenario.
        """
        rows: list[list[list[float]]] = [[] for _ in settings_of]
        for _, candidates, _, episodes in self.runs:
            policies = [candidates.make_policy(settings(candidates)) for settings in settings_of]
            for own, outcome in zip(rows, episodes.run_all(policies), strict=True):
                own.append(outcome.scores.tolist())
        return list(rows)


@dataclass
class _Running:
    """A candidate that is being run.

    Attributes:
        number: index of the candidate among those that are run side by side.
        means: mean scores in the scenarios so far [1].
        steps: control steps so far.
    """

    number: int
    means: list[float] = field(default_factory=list)
    steps: int = 0

    def measured(self, best: Trial | None) -> CandidateScore:
        """What running it gave; an estimate from the best trial where it was stopped."""
        means = tuple(self.means)
        if best is None:
            return CandidateScore(_mean(means), self.steps, means, stopped=False)
        return CandidateScore(_estimate(means, best), self.steps, means, stopped=True)


def mean_score(rows: EpisodeRows) -> float:
    """The mean over scenarios of the mean over episodes [1]."""
    return _mean([_episode_mean(own) for own in rows])


def _episode_mean(scores: Array | Sequence[float]) -> float:
    return float(np.mean(scores))


def _mean(values: Sequence[float]) -> float:
    return sum(values) / len(values)


def _is_hopeless(means: Sequence[float], best: Sequence[float]) -> bool:
    lost = sum(1.0 - mean for mean in means)
    return lost > HOPELESS * sum(1.0 - mean for mean in best[: len(means)])


def _estimate(means: Sequence[float], best: Trial) -> float:
    differences = [theirs - own for own, theirs in zip(means, best.by_scenario, strict=False)]
    return max(0.0, best.score - _mean(differences))
