"""Every metric of an episode, one module for each family.

A metric is a pure function of what was recorded, declared with unit and definition; it exists for an
episode that has the fields and cost terms which it requires. Its values are finite, with these exceptions:

- NaN, where the episode has no such value: settling times and overshoots if the reference moves, overshoots
  if start and goal coincide, steady-state errors if the reference moves in the last tenth, every metric of
  the desired force if that is zero (its settling time and overshoot also if it changes), the torque's rate
  of a single step, and after a divergence all but the score and the divergence.
- Infinite, where a settling time was not reached: outside the band at the end, or never in contact.

An episode without contact has peak force, contact losses, force overshoot and injected energy 0.
"""

from prp_gym.checks import instance
from prp_gym.evaluation.metric import Metric
from prp_gym.evaluation.rollout import Rollout
from prp_gym.registry import Registry
from prp_gym.robot.arrays import Array
from prp_gym.robot.shared import sharing

METRICS: Registry[Metric] = Registry("metric", "prp_gym.evaluation.metrics")
"""The declared metrics by name, in the order of results and pages."""


def register_metric(metric: Metric) -> Metric:
    """Declare a metric, of this package or of another.

    Args:
        metric: the declaration; episodes that have what it requires have the metric from then on.

    Returns:
        the declaration.

    Raises:
        InvalidValueError: a name that another metric has, or that cannot be a name; a revision below 1.
    """
    return METRICS.register(instance("metric", metric, Metric))


def episode_metrics(rollout: Rollout) -> dict[str, Array]:
    """Every metric that exists for an episode, by name."""
    with sharing():
        return {name: metric.values(rollout) for name, metric in METRICS.items() if metric.exists(rollout)}
