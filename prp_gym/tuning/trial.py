"""A candidate, and its score."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Trial:
    """A candidate that was evaluated.

    Attributes:
        factors: factors of the search space, by the names of its parameters.
        score: mean score over the scenarios [1]; an estimate where the candidate was stopped.
        steps: control steps that the trial uses of the budget.
        seconds: wall time of the trial [s].
        by_scenario: mean score over the episodes of each scenario that was run, in their order [1].
        stopped: whether further scenarios were left out, the candidate being far worse than the best one.
        slopes: derivatives of the score by the logarithms of the factors, by the names of their parameters;
            empty where the search does not use them, and for a candidate that was refused.
    """

    factors: Mapping[str, float]
    score: float
    steps: int
    seconds: float
    by_scenario: tuple[float, ...] = ()
    stopped: bool = False
    slopes: Mapping[str, float] = field(default_factory=dict)


def best_trial(trials: Sequence[Trial]) -> Trial | None:
    """The first of the best trials that were run in all scenarios; None where there is none."""
    return max((trial for trial in trials if not trial.stopped), key=lambda trial: trial.score, default=None)
