"""`tune`: candidates are played until the budget is spent; the best one is the result."""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import gymnasium

from prp_gym.baselines import BASELINES, make_baseline
from prp_gym.baselines.gains import load_gains
from prp_gym.errors import InvalidValueError, PRPError, UnknownNameError
from prp_gym.evaluation.evaluate import episodes_to_run
from prp_gym.tuning.episodes import Episodes
from prp_gym.tuning.search_space import SearchSpace
from prp_gym.tuning.task import TuningTask
from prp_gym.tuning.trial import Trial


class Study(Protocol):
    """Where candidates come from; see `StoredStudy`."""

    trials: list[Trial]

    def propose(self) -> dict[str, float]:
        """The factors of the next candidate."""

    def record(self, score: float, steps: int, seconds: float) -> Trial:
        """Finish the candidate that was proposed last."""


@dataclass(frozen=True, eq=False)
class Tuned:
    """What a search came to.

    Attributes:
        trials: all candidates, in their order; the first is the law's own `tuned` set.
        settings: of the best of them, for `make_baseline`.
    """

    trials: Sequence[Trial]
    settings: Mapping[str, Any]

    @property
    def best(self) -> Trial:
        """The first trial with the highest score."""
        return max(self.trials, key=lambda trial: trial.score)

    @property
    def used_steps(self) -> int:
        """Steps that the trials are charged."""
        return sum(trial.steps for trial in self.trials)

    @property
    def history(self) -> list[tuple[int, float]]:
        """Steps and best score so far, wherever it rose, and at the end."""
        points: list[tuple[int, float]] = []
        used, best = 0, -1.0
        for trial in self.trials:
            used += trial.steps
            if trial.score > best:
                best = trial.score
                points.append((used, best))
        return points if points[-1][0] == used else [*points, (used, best)]


def start_gains(controller: str, environment_id: str, control_frequency: float) -> str:
    """The gain set from which a search starts: `tuned`, or the one for 50 Hz where that is too fast."""
    least = load_gains(controller, "tuned", environment_id).get("minimum_frequency", 0.0)
    return "tuned" if control_frequency >= least else "tuned_50hz"


def search_space(task: TuningTask, env: gymnasium.Env[Any, Any]) -> SearchSpace:
    """What may be changed of a law on an environment.

    Raises:
        PRPError: a law that does not exist, or does not run on the environment or at its control frequency.
    """
    if task.controller not in BASELINES:
        raise UnknownNameError("baseline", task.controller, BASELINES)
    gains = start_gains(task.controller, task.environment_id, task.control_frequency)
    return SearchSpace.of(make_baseline(task.controller, env, gains))


def tune(
    task: TuningTask,
    env: gymnasium.Env[Any, Any],
    space: SearchSpace,
    study: Study,
    on_trial: Callable[[Trial], None] = lambda trial: None,
) -> Tuned:
    """Play candidates, the trials of the study first, until no other one fits into the budget.

    All candidates play the same episodes, so that they differ by their settings alone: scores of one
    candidate vary from episode to episode by far more than those of good candidates from one another. What
    the search may gain by chance on these episodes, others, which no search uses, show.

    A candidate is charged the steps that were simulated; one that the law refuses scores 0 and is charged as
    if it had been played.

    Args:
        task: what is tuned.
        env: the environment of the task.
        space: that the study searches.
        study: proposes candidates.
        on_trial: called after each trial that is played, for progress bars.

    Returns:
        the trials and the best settings.

    Raises:
        InvalidValueError: a budget for not even one candidate.
    """
    seeds = range(task.first_seed, task.first_seed + episodes_to_run(env, task.episodes))
    episodes = Episodes(env, seeds)
    if task.budget < episodes.most_steps:
        raise InvalidValueError("budget", task.budget, f"at least {episodes.most_steps}, one trial", "steps")
    used = sum(trial.steps for trial in study.trials)
    while used + episodes.most_steps <= task.budget:
        before = time.perf_counter()
        factors = study.propose()
        score, steps = _play(task.controller, env, space.settings(factors), episodes)
        trial = study.record(score, steps, time.perf_counter() - before)
        used += trial.steps
        on_trial(trial)
    best = max(study.trials, key=lambda trial: trial.score)
    return Tuned(tuple(study.trials), space.settings(best.factors))


def _play(
    controller: str, env: gymnasium.Env[Any, Any], settings: Mapping[str, Any], episodes: Episodes
) -> tuple[float, int]:
    """The mean score of a candidate, and the steps that it is charged."""
    try:
        policy = make_baseline(controller, env, "tuned", **settings)
    except PRPError:
        return 0.0, episodes.most_steps
    scores, steps = episodes.run(policy)
    return float(scores.mean()), steps
