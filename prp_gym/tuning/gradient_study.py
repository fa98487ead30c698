"""`GradientStudy`: the trials of a search along the derivatives of the score."""

from collections.abc import Sequence
from typing import ClassVar

from prp_gym.tuning.gradient_step import gradient_step
from prp_gym.tuning.local_step import is_local
from prp_gym.tuning.search_space import Parameter
from prp_gym.tuning.stored_study import StoredStudy
from prp_gym.tuning.trial import Trial


class GradientStudy(StoredStudy):
    """Proposals for candidates along the derivatives of the score, one after the other.

    One candidate in six comes from Optuna's sampler, as in a `StoredStudy`, since derivatives lead uphill
    only; the others come from `gradient_step`.
    """

    candidates_of_a_round: ClassVar[int] = 1

    def _propose(
        self, index: int, parameters: Sequence[Parameter], known: Sequence[Trial]
    ) -> dict[str, float]:
        if is_local(index):
            return gradient_step(parameters, known, self.seed)
        return super()._propose(index, parameters, known)
