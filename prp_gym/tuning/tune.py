"""`tune`: candidates are evaluated until the budget is spent; the best one is the result."""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import gymnasium

from prp_gym.baselines import CONTROLLERS, ControllerSpec, make_baseline
from prp_gym.baselines.base.gains import load_gains
from prp_gym.errors import InvalidValueError, PRPError
from prp_gym.evaluation.evaluate import episodes_to_run
from prp_gym.tuning.candidates import Candidates
from prp_gym.tuning.episodes import Episodes
from prp_gym.tuning.search_space import SearchSpace
from prp_gym.tuning.task import TuningTask
from prp_gym.tuning.trial import Trial

TUNED, SLOW = "tuned", "tuned_50hz"
"""Gain sets from which searches start."""


class Study(Protocol):
    """Proposes candidates and keeps their scores; see `StoredStudy`."""

    trials: list[Trial]

    def propose(self) -> dict[str, float]:
        """The factors of the next candidate."""

    def record(self, score: float, steps: int, seconds: float) -> Trial:
        """Finish the candidate that was proposed last."""


@dataclass(frozen=True, eq=False)
class Tuned:
    """Result of a search.

    Attributes:
        trials: all candidates in their order; the first has the gains from which the search started.
        settings: settings of the best candidate, by name.
    """

    trials: Sequence[Trial]
    settings: Mapping[str, Any]

    @property
    def best(self) -> Trial:
        """The first trial with the highest score."""
        return max(self.trials, key=lambda trial: trial.score)

    @property
    def used_steps(self) -> int:
        """Control steps that the trials count against the budget."""
        return sum(trial.steps for trial in self.trials)

    @property
    def history(self) -> list[tuple[int, float]]:
        """Control steps and best score so far, wherever it rose, and at the end."""
        points: list[tuple[int, float]] = []
        used, best = 0, -1.0
        for trial in self.trials:
            used += trial.steps
            if trial.score > best:
                best = trial.score
                points.append((used, best))
        return points if points[-1][0] == used else [*points, (used, best)]


def start_gains(controller: ControllerSpec, environment_id: str, control_frequency: float) -> str:
    """The gain set from which a search starts: `tuned`, or the one for 50 Hz where that is unstable.

    Args:
        controller: declaration of the controller.
        environment_id: id of the environment.
        control_frequency: control frequency of the environment [Hz].
    """
    least = load_gains(controller, TUNED, environment_id).get("minimum_frequency", 0.0)
    return TUNED if control_frequency >= least else SLOW


def make_candidates(task: TuningTask, env: gymnasium.Env[Any, Any]) -> Candidates:
    """The candidates for a registered controller, around the gains from which a search of it starts.

    Args:
        task: controller, environment and budget.
        env: the environment of the task.

    Raises:
        PRPError: a controller that does not exist, or does not run on the environment or at its control
            frequency.
    """
    spec = CONTROLLERS.find(task.controller)
    start = make_baseline(spec, env, start_gains(spec, task.environment_id, task.control_frequency))
    return Candidates(SearchSpace.of(spec, start.settings), lambda values: make_baseline(spec, env, **values))


def tune(
    task: TuningTask,
    env: gymnasium.Env[Any, Any],
    candidates: Candidates,
    study: Study,
    on_trial: Callable[[Trial], None] = lambda trial: None,
) -> Tuned:
    """Evaluate candidates, the trials of the study first, until the budget has no room for another one.

    All candidates run the same episodes, so that they differ by their settings alone: the scores of one
    candidate vary from episode to episode by far more than those of good candidates from one another. How
    much the search has gained by chance on these episodes is shown by others that no search uses.

    A candidate counts the control steps that were simulated; one that the controller refuses scores 0 and
    counts as if all its episodes had been simulated.

    Args:
        task: controller, environment and budget.
        env: the environment of the task.
        candidates: policies that the search evaluates, by their factors.
        study: search method that proposes factors.
        on_trial: function that is called after each new trial, for progress bars.

    Returns:
        the trials and the best settings.

    Raises:
        InvalidValueError: a budget that is too small for one candidate.
    """
    seeds = range(task.first_seed, task.first_seed + episodes_to_run(env, task.episodes))
    episodes = Episodes(env, seeds)
    if task.budget < episodes.most_steps:
        raise InvalidValueError("budget", task.budget, f"at least {episodes.most_steps}, one trial", "steps")
    used = sum(trial.steps for trial in study.trials)
    while used + episodes.most_steps <= task.budget:
        before = time.perf_counter()
        score, steps = _score(candidates, study.propose(), episodes)
        trial = study.record(score, steps, time.perf_counter() - before)
        used += trial.steps
        on_trial(trial)
    best = max(study.trials, key=lambda trial: trial.score)
    return Tuned(tuple(study.trials), candidates.space.settings(best.factors))


def _score(candidates: Candidates, factors: Mapping[str, float], episodes: Episodes) -> tuple[float, int]:
    """The mean score of a candidate, and the control steps that it counts."""
    try:
        policy = candidates.make(factors)
    except PRPError:
        return 0.0, episodes.most_steps
    scores, steps = episodes.run(policy)
    return float(scores.mean()), steps
