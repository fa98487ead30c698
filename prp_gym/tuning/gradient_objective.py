"""`GradientObjective`: what a search maximises, with its derivatives by the factors of a candidate."""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from prp_gym.errors import NonFiniteError, PRPError
from prp_gym.evaluation.rollout import Policy
from prp_gym.gradients.differentiated_episodes import DifferentiatedEpisodes
from prp_gym.robot.arrays import Array
from prp_gym.tuning.candidates import Candidates
from prp_gym.tuning.objective import CandidateScore, Objective
from prp_gym.tuning.trial import Trial

LARGEST_SLOPE = 1.0
"""Largest derivative of an episode's score by the logarithm of a factor that tells anything: scores lie in
[0, 1]. In limit cycles and repeated impacts, where scores are chaotic, derivatives grow exponentially with
time; such episodes are left out of a sum of derivatives."""

_STEP = 1e-4  # in the logarithm of a factor


class GradientObjective(Objective):
    """The mean score of an `Objective`, with its exact derivatives, where they tell anything.

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
        means, steps, slopes = [], 0, np.zeros(len(factors))
        for run in self.runs:
            try:
                policy = run.candidates.make(factors)
            except PRPError:
                return self._refused()
            try:
                found = DifferentiatedEpisodes(run.env, policy, run.seeds)
            except NonFiniteError:
                return self._refused()
            means.append(float(np.mean(found.scores)))
            steps += int(np.where(found.ended > 0, found.ended, run.episodes.horizon).sum())
            rows = np.stack([_slopes(found, run.candidates, factors, name) for name in factors])
            tells = np.isfinite(rows).all(axis=0) & (np.abs(rows) <= LARGEST_SLOPE).all(axis=0)
            slopes += np.where(tells, rows, 0.0).mean(axis=1) / len(self.runs)
        by_factor = dict(zip(factors, slopes.tolist(), strict=True))
        return CandidateScore(sum(means) / len(means), steps, tuple(means), stopped=False, slopes=by_factor)

    def _refused(self) -> CandidateScore:
        return CandidateScore(0.0, self.most_steps, (0.0,) * len(self.runs), stopped=False)


def _slopes(
    found: DifferentiatedEpisodes, candidates: Candidates, factors: Mapping[str, float], name: str
) -> Array:
    """The derivative of each score by the logarithm of a factor (N); 0 where the factor cannot be changed."""

    def make(distance: float) -> Policy:
        return candidates.make({**factors, name: factors[name] * math.exp(distance)})

    slopes = found.derivatives(make, _STEP)
    return np.zeros_like(found.scores) if slopes is None else slopes
