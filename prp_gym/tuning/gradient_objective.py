"""`GradientObjective`: what a search maximises, with its derivatives by the factors of a candidate."""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from prp_gym.errors import NonFiniteError, PRPError
from prp_gym.evaluation.rollout import Policy
from prp_gym.gradients.differentiated_episodes import DifferentiatedEpisodes
from prp_gym.tuning.candidates import Candidates
from prp_gym.tuning.objective import CandidateScore, Objective
from prp_gym.tuning.trial import Trial

_STEP = 1e-4  # of the logarithm of a factor, see `by_settings`


class GradientObjective(Objective):
    """The mean score of an `Objective`, with its exact derivatives.

    Episodes run in compiled code, whatever the engine of the environments, with actions that are not rounded
    to single precision: scores differ from those of an `Objective` by about 1e-7. Every candidate runs
    all of its episodes, which count against the budget once: the reverse sweep simulates nothing.

    Args:
        conditions: the scenarios with their candidates, at least one.
        first_seed: seed of the first episode.
        episodes: number of episodes, see `Objective`.

    Raises:
        UntraceableError: (by `measure`) a task or controller without derivatives.
    """

    def measure(self, proposals: Sequence[Mapping[str, float]], best: Trial | None) -> list[CandidateScore]:
        """Run candidates; one that is refused or not finite scores 0 and has no derivatives.

        Args:
            proposals: factors of the search space for each candidate, by the names of its parameters.
            best: has no effect.

        Returns:
            one for each candidate.
        """
        return [self._measured(factors) for factors in proposals]

    def _measured(self, factors: Mapping[str, float]) -> CandidateScore:
        means, steps = [], 0
        slopes = dict.fromkeys(factors, 0.0)
        for run in self.runs:
            try:
                policy = run.candidates.make(factors)
                found = DifferentiatedEpisodes(run.env, policy, run.seeds)
            except NonFiniteError:
                return CandidateScore(0.0, self.most_steps, (0.0,) * len(self.runs), stopped=False)
            means.append(float(np.mean(found.scores)))
            steps += int(np.where(found.ended > 0, found.ended, run.episodes.horizon).sum())
            for name in factors:
                slopes[name] += _slope(found, run.candidates, policy, factors, name) / len(self.runs)
        return CandidateScore(sum(means) / len(means), steps, tuple(means), stopped=False, slopes=slopes)


def _slope(
    found: DifferentiatedEpisodes,
    candidates: Candidates,
    policy: Policy,
    factors: Mapping[str, float],
    name: str,
) -> float:
    """The derivative of the mean score by the logarithm of one factor; one-sided where a side is refused."""

    def change(step: float) -> float | None:
        try:
            other = candidates.make({**factors, name: factors[name] * math.exp(step)})
        except PRPError:
            return None
        return found.difference(other, policy)

    above, below = change(_STEP), change(-_STEP)
    if above is not None and below is not None:
        return (above - below) / (2.0 * _STEP)
    if above is not None:
        return above / _STEP
    return 0.0 if below is None else -below / _STEP
