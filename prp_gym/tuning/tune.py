"""`tune`: candidates are evaluated until the budget is spent."""

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import gymnasium

from prp_gym.baselines import CONTROLLERS, ControllerSpec, make_baseline
from prp_gym.baselines.base.gains import load_gains
from prp_gym.errors import InvalidValueError
from prp_gym.tuning.candidates import Candidates
from prp_gym.tuning.objective import Objective
from prp_gym.tuning.search_space import SearchSpace
from prp_gym.tuning.task import TuningTask
from prp_gym.tuning.trial import Trial, best_trial
from prp_gym.tuning.widening import Ranges

TUNED, SLOW = "tuned", "tuned_50hz"
"""Gain sets from which searches start."""

EXTRA = 0.25
"""Share of the budget that is added while the best candidate lies at an edge that is no limit."""


class Study(Protocol):
    """Proposes candidates and keeps their scores; see `StoredStudy`."""

    trials: list[Trial]

    @property
    def known(self) -> Sequence[Trial]:
        """The trials before the current round."""

    def ranges(self, trials: Sequence[Trial]) -> Ranges:
        """The ranges of the factors after some trials."""

    def propose(self) -> list[dict[str, float]]:
        """The factors of the candidates that are left of the current round, at least one."""

    def record(self, trial: Trial) -> None:
        """Keep a finished trial."""


@dataclass(frozen=True, eq=False)
class Tuned:
    """What a search has tried.

    Attributes:
        trials: all candidates in their order; the first has the gains from which the search started.
        ranges: ranges of the factors at the end, and the edges at which the best candidate lies.
    """

    trials: Sequence[Trial]
    ranges: Ranges

    @property
    def best(self) -> Trial:
        """The first trial with the highest score."""
        best = best_trial(self.trials)
        return self.trials[0] if best is None else best

    @property
    def used_steps(self) -> int:
        """Control steps that the trials count against the budget."""
        return sum(trial.steps for trial in self.trials)

    @property
    def history(self) -> list[tuple[int, Trial]]:
        """Control steps and best trial so far, wherever its score rose, and at the end."""
        points: list[tuple[int, Trial]] = []
        used = 0
        for trial in self.trials:
            used += trial.steps
            if not points or (not trial.stopped and trial.score > points[-1][1].score):
                points.append((used, trial))
        return points if points[-1][0] == used else [*points, (used, points[-1][1])]


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
        env: the environment of the task in one of its scenarios.

    Raises:
        PRPError: a controller that does not exist, or does not run on the environment or at its control
            frequency.
    """
    spec = CONTROLLERS.find(task.controller)
    start = make_baseline(spec, env, start_gains(spec, task.environment_id, task.control_frequency))
    return Candidates(SearchSpace.of(spec, start.settings), lambda values: make_baseline(spec, env, **values))


def tune(
    task: TuningTask,
    objective: Objective,
    study: Study,
    on_trial: Callable[[Trial], None] = lambda trial: None,
) -> Tuned:
    """Evaluate candidates, the trials of the study first, until the budget has no room for another one.

    All candidates run the same episodes, so that they differ by their settings alone: the scores of one
    candidate vary from episode to episode by far more than those of good candidates from one another. How
    much the search has gained by chance on these episodes is shown by others that no search uses.

    A candidate counts the control steps that were simulated. Where the best one lies at an edge of its range
    that is no limit, the search goes on in the wider range for up to `EXTRA` of the budget more.

    Args:
        task: controller, environment and budget.
        objective: what is maximised, on the training episodes of the task.
        study: search method that proposes factors.
        on_trial: function that is called after each new trial, for progress bars.

    Returns:
        the trials, and the edges at which the best one lies.

    Raises:
        InvalidValueError: a budget that is too small for one candidate.
    """
    if task.budget < objective.most_steps:
        raise InvalidValueError("budget", task.budget, f"at least {objective.most_steps}, one trial", "steps")
    used = sum(trial.steps for trial in study.trials)
    while room := int((_allowed(task, study) - used) // objective.most_steps):
        before = time.perf_counter()
        proposals = study.propose()[:room]
        found = objective.measure(proposals, best_trial(study.known))
        seconds = (time.perf_counter() - before) / len(found)
        for factors, item in zip(proposals, found, strict=True):
            trial = Trial(
                *(factors, item.score, item.steps, seconds, item.by_scenario, item.stopped),
                dict(item.slopes),
            )
            study.record(trial)
            used += trial.steps
            on_trial(trial)
    return Tuned(tuple(study.trials), study.ranges(study.trials))


def _allowed(task: TuningTask, study: Study) -> int:
    """Control steps that may be used in this round, given where the best candidate before it lies."""
    extra = EXTRA if study.ranges(study.known).is_open else 0.0
    return math.floor(task.budget * (1.0 + extra))
