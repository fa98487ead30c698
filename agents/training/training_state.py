"""`TrainingState`: the progress of a training run: learning curve, violations and best policy."""

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
    """Violated limits in training, summed over all steps of all environments.

    Attributes:
        joint_stop: number of joints beyond a joint stop, summed over the steps.
        force_bound: number of steps with a contact force beyond the bound of the task.
        divergences: number of simulations that diverged.
    """

    joint_stop: float = 0.0
    force_bound: float = 0.0
    divergences: int = 0

    def add(self, infos: Sequence[Mapping[str, Any]], dones: NDArray[np.bool_]) -> None:
        """Count the violations of one step of all environments."""
        for name, key in _COSTS.items():
            if key in infos[0]:
                setattr(self, name, getattr(self, name) + float(sum(info[key] for info in infos)))
        self.divergences += sum(not infos[index][_TRUNCATED] for index in np.flatnonzero(dones).tolist())


@dataclass(frozen=True)
class CurveRow:
    """One evaluation of a policy in training.

    Attributes:
        steps: number of training steps so far.
        seconds: wall-clock time of training so far, including evaluations and runs before a resume [s].
        score: mean reward over held-out episodes.
        violations: number of violated limits in training so far, by the kind of limit.
    """

    steps: int
    seconds: float
    score: float
    violations: Mapping[str, float]


@dataclass(frozen=True)
class BestPolicy:
    """The policy with the best score so far.

    Attributes:
        steps: number of training steps after which it was stored.
        score: score of the policy on the held-out episodes.
        weights: state dictionary of the policy.
        normalizer: normaliser of the policy's features.
    """

    steps: int
    score: float
    weights: Mapping[str, Any]
    normalizer: Normalizer


@dataclass
class TrainingState:
    """The progress of a run, without what the model itself stores.

    Attributes:
        curve: evaluations, in order.
        violations: violated limits so far.
        seconds: wall-clock time of training so far, including runs before a resume [s].
        evaluation_seconds: part of that time which evaluations took [s].
        resumes: number of times that training was resumed.
        best: list that holds the best policy; empty before the first evaluation.
    """

    curve: list[CurveRow] = field(default_factory=list)
    violations: Violations = field(default_factory=Violations)
    seconds: float = 0.0
    evaluation_seconds: float = 0.0
    resumes: int = 0
    best: list[BestPolicy] = field(default_factory=list)

    def plain_curve(self) -> dict[str, Any]:
        """Content of the file with the learning curve."""
        return {"unit_of_seconds": "s", "rows": [asdict(row) for row in self.curve]}
