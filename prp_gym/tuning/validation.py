"""Validation: the best candidates of a search on fresh episodes, from which its result is chosen."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Protocol

import numpy as np

from prp_gym.tuning.candidates import Candidates
from prp_gym.tuning.objective import EpisodeRows, Objective, mean_score
from prp_gym.tuning.task import FINAL_EPISODES, VALIDATION_SEED
from prp_gym.tuning.trial import Trial
from prp_gym.tuning.tune import Tuned

CANDIDATES, SELECTION_EPISODES = 10, 20
"""The best candidates on the training episodes, and the fresh episodes that choose among them."""

FINALISTS = 3
"""The best candidates on these, which further fresh episodes compare with the start."""

STANDARD_ERRORS = 2.0
"""A candidate is better than the start if its mean is higher by more than so many errors of the gain."""

DIGITS = 4
"""Significant digits of the settings that are validated, and that are the result."""

_SELECTION_SEED = VALIDATION_SEED + 1_000_000


class Scores(Protocol):
    """Keeps scores, so that a search that was killed in its validation goes on there; see `StoredScores`."""

    def find(
        self, names: Sequence[str], compute: Callable[[Sequence[str]], Sequence[EpisodeRows]]
    ) -> list[EpisodeRows]:
        """The scores of these names; those that are not kept are computed together."""


@dataclass(frozen=True, kw_only=True)
class Validation:
    """Mean scores on episodes that the search did not use, and that its budget does not count.

    Attributes:
        seed: seed of the first of the final episodes.
        episodes: number of final episodes.
        score: score of the settings that were chosen [1].
        score_of_start: score of the settings from which the search started [1].
        kept_start: whether these were chosen, since no candidate was better.
        gain: mean score of the best finalist less that of the start [1]; 0 without a finalist.
        gain_error: standard error of the gain over the final episodes, which both ran [1].
        selection_seed: seed of the first episode on which the finalists were selected.
        selection_episodes: number of these episodes.
        selection: scores of the best candidates on these episodes, in the order of their training scores [1].
        finalists: scores of the finalists on the final episodes, in the order of the selection [1].
    """

    seed: int
    episodes: int
    score: float
    score_of_start: float
    kept_start: bool
    gain: float
    gain_error: float
    selection_seed: int
    selection_episodes: int
    selection: tuple[float, ...]
    finalists: tuple[float, ...]


@dataclass(frozen=True, eq=False)
class Choice:
    """The result of a search: what was chosen, and why.

    Attributes:
        trial: trial that was chosen; the first one, where the start was kept.
        validation: scores on fresh episodes.
    """

    trial: Trial
    validation: Validation


def choose(
    tuned: Tuned,
    make_objective: Callable[[int, int], Objective],
    scores: Scores,
    final_episodes: int = FINAL_EPISODES,
) -> Choice:
    """Validate the best candidates of a search, and choose one of them or the start.

    The ten best candidates run 20 fresh episodes, the best three of them further ones together with the
    start. The best of these is chosen, the start unless a candidate's mean is higher by more than
    `STANDARD_ERRORS` of the difference: the episodes cannot tell smaller ones from chance, and there are
    three to choose from. The candidates' settings are rounded before; those of the start are left as they
    are.

    Args:
        tuned: what the search has tried.
        make_objective: function that gives the objective on so many episodes, from a seed on.
        scores: scores that are kept.
        final_episodes: number of the further fresh episodes.
    """
    objective = make_objective(_SELECTION_SEED, SELECTION_EPISODES)
    final = make_objective(VALIDATION_SEED, final_episodes)

    def scored(stage: Objective, names: Sequence[str]) -> list[EpisodeRows]:
        return stage.episode_scores([settings_of[name.partition(" ")[2]] for name in names])

    best = _best_indices(tuned.trials)
    settings_of: dict[str, Callable[[Candidates], Mapping[str, Any]]] = {
        str(index): partial(rounded_settings, factors=tuned.trials[index].factors) for index in best
    }
    settings_of["start"] = start_settings
    rows = scores.find([f"selection {index}" for index in best], lambda names: scored(objective, names))
    selection = [mean_score(own) for own in rows]
    order = sorted(range(len(best)), key=lambda number: -selection[number])[:FINALISTS]
    finalists = [best[number] for number in order]
    named = [f"final {index}" for index in finalists]
    *rows, start = scores.find([*named, "final start"], lambda names: scored(final, names))
    results = [mean_score(own) for own in rows]
    chosen, score, gain, error = 0, mean_score(start), 0.0, 0.0
    if finalists:
        leader = max(range(len(results)), key=results.__getitem__)
        gain, error = paired_gain(rows[leader], start)
        if gain > STANDARD_ERRORS * error:
            chosen, score = finalists[leader], results[leader]
    return Choice(
        tuned.trials[chosen],
        Validation(
            seed=VALIDATION_SEED,
            episodes=final.episodes,
            score=score,
            score_of_start=mean_score(start),
            kept_start=chosen == 0,
            gain=gain,
            gain_error=error,
            selection_seed=_SELECTION_SEED,
            selection_episodes=objective.episodes,
            selection=tuple(selection),
            finalists=tuple(results),
        ),
    )


def paired_gain(rows: EpisodeRows, start: EpisodeRows) -> tuple[float, float]:
    """By how much scores are higher than those of the start on the same episodes, and its standard error.

    Args:
        rows: scores by scenario and episode [1].
        start: those of the start [1].

    Returns:
        the mean over scenarios of the mean difference, and its standard error [1]; a single episode, of a
        deterministic scenario, has none.
    """
    differences = [np.subtract(own, other) for own, other in zip(rows, start, strict=True)]
    variances = [item.var(ddof=1) / item.size if item.size > 1 else 0.0 for item in differences]
    gain = float(np.mean([item.mean() for item in differences]))
    return gain, math.sqrt(sum(variances)) / len(differences)


def start_settings(candidates: Candidates) -> Mapping[str, Any]:
    """The settings from which a search starts, as they are."""
    return candidates.space.settings(candidates.space.start)


def rounded_settings(candidates: Candidates, factors: Mapping[str, float]) -> dict[str, Any]:
    """The settings that factors give, every number rounded to four significant digits."""
    return {name: _rounded(value) for name, value in candidates.space.settings(factors).items()}


def _best_indices(trials: Sequence[Trial]) -> list[int]:
    """Indices of the best candidates that were not stopped, without the start, best first."""
    complete = [index for index, trial in enumerate(trials) if index and not trial.stopped]
    return sorted(complete, key=lambda index: -trials[index].score)[:CANDIDATES]


def _rounded(value: Any) -> Any:
    """A number, or an array, a list or a tuple of numbers, rounded; anything else as it is."""
    if isinstance(value, np.ndarray):
        return np.array([_rounded(item) for item in value.tolist()]) if value.ndim else _rounded(value.item())
    if isinstance(value, (list, tuple)):
        return type(value)(_rounded(item) for item in value)
    if isinstance(value, float):
        return float(f"{value:.{DIGITS}g}")
    return value
