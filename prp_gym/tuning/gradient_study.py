"""`GradientStudy`: the trials of a search along the derivatives of the score."""

from collections.abc import Sequence
from typing import ClassVar

from prp_gym.tuning.gradient_step import gradient_step
from prp_gym.tuning.search_space import Parameter
from prp_gym.tuning.stored_study import StoredStudy
from prp_gym.tuning.trial import Trial


class GradientStudy(StoredStudy):
    """Proposals for candidates along the derivatives of the score, one after the other; see `StoredStudy`."""

    candidates_of_a_round: ClassVar[int] = 1

    def _propose(
        self, index: int, parameters: Sequence[Parameter], known: Sequence[Trial]
    ) -> dict[str, float]:
        return gradient_step(parameters, known, self.seed)
