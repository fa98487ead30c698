"""Every metric of an episode, by the kind of question that it answers.

A metric is a pure function of what was recorded, declared with unit and definition; it exists for an
episode that has the fields and cost terms which it requires. Its values are finite but for these:

- NaN, where the episode has no such value: settling times and overshoots if the reference moves, overshoots
  if start and goal are one, steady-state errors if the reference moves in the last tenth, every metric of
  the desired force if that is zero (its settling time and overshoot also if it changes), the torque's rate
  of a single step, and after a divergence all but the score and the divergence.
- Infinite, where a settling time was not reached: outside the band at the end, or never in contact.

An episode without contact has peak force, contact losses, force overshoot and injected energy 0.
"""

import numpy as np

from prp_gym.evaluation.effort_metrics import EFFORT_METRICS
from prp_gym.evaluation.force_metrics import CONTACT_METRICS, FORCE_METRICS
from prp_gym.evaluation.joint_metrics import JOINT_METRICS
from prp_gym.evaluation.metric import Metric, OutcomeMetric
from prp_gym.evaluation.pose_metrics import MODEL_METRICS, POSE_METRICS
from prp_gym.evaluation.rollout import Rollout
from prp_gym.robot.arrays import Array

OUTCOME_METRICS: tuple[Metric, ...] = (
    OutcomeMetric(
        "score",
        ("1",),
        "return over duration, in [0, 1]; what is lost after a divergence counts as 0",
        (),
        lambda r: np.array([r.reward.sum() / r.duration]),
        higher_is_better=True,
    ),
    OutcomeMetric(
        "divergence",
        ("%",),
        "share of episodes that ended in a divergence",
        (),
        lambda r: np.array([100.0 * r.diverged]),
    ),
)

GROUPS = {
    "Outcome": OUTCOME_METRICS,
    "Joint motion": JOINT_METRICS,
    "Tip motion": POSE_METRICS,
    "Reference model": MODEL_METRICS,
    "Desired force": FORCE_METRICS,
    "Contact": CONTACT_METRICS,
    "Effort": EFFORT_METRICS,
}
"""Metrics by the kind of question that they answer."""

METRICS: tuple[Metric, ...] = tuple(metric for group in GROUPS.values() for metric in group)


def episode_metrics(rollout: Rollout) -> dict[str, Array]:
    """Every metric that exists for an episode, by name."""
    return {metric.name: metric.values(rollout) for metric in METRICS if metric.exists(rollout)}
