"""What a run of training has come to: its curve, its violations, its best policy."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from prp_gym.agents.policy.normalizer import Normalizer

_COSTS = {"joint_stop": "cost_joint_stop", "force_bound": "cost_force_bound"}
_TRUNCATED = "TimeLimit.truncated"


@dataclass
class Violations:
    """What went wrong in training, summed over all steps of all environments.

    Attributes:
        joint_stop: joints beyond a stop.
        force_bound: steps with a force beyond the task's bound.
        divergences: simulations that diverged.
    """

    joint_stop: float = 0.0
    force_bound: float = 0.0
    divergences: int = 0

    def add(self, infos: Sequence[Mapping[str, Any]], dones: NDArray[np.bool_]) -> None:
        """Count one step of all environments."""
        for name, key in _COSTS.items():
            if key in infos[0]:
                setattr(self, name, getattr(self, name) + float(sum(info[key] for info in infos)))
        self.divergences += sum(not infos[index][_TRUNCATED] for index in np.flatnonzero(dones).tolist())


@dataclass(frozen=True)
class CurveRow:
    """One evaluation of a policy in training.

    Attributes:
        steps: of training so far.
        seconds: of training so far, evaluations included, those before a resume too [s].
        score: mean of return / duration over held-out episodes.
        violations: in training so far.
    """

    steps: int
    seconds: float
    score: float
    violations: Mapping[str, float]


@dataclass(frozen=True)
class BestPolicy:
    """The policy with the best score so far.

    Attributes:
        steps: of training that it had.
        score: of it.
        weights: state dictionary of the policy.
        normalizer: of its features.
    """

    steps: int
    score: float
    weights: Mapping[str, Any]
    normalizer: Normalizer


@dataclass
class TrainingState:
    """What a run has come to, beside what the model itself knows.

    Attributes:
        curve: evaluations, in order.
        violations: so far.
        seconds: of training so far, before a resume too [s].
        evaluation_seconds: of them for evaluations [s].
        resumes: how often training went on.
        best: list of the best policy, empty before the first evaluation.
    """

    curve: list[CurveRow] = field(default_factory=list)
    violations: Violations = field(default_factory=Violations)
    seconds: float = 0.0
    evaluation_seconds: float = 0.0
    resumes: int = 0
    best: list[BestPolicy] = field(default_factory=list)

    def plain_curve(self) -> dict[str, Any]:
        """Content of the curve's file."""
        return {"unit_of_seconds": "s", "rows": [asdict(row) for row in self.curve]}
