"""Metrics of the outcome of an episode: its score, and whether it ended in a divergence."""

from prp_gym.evaluation.metric import MetricGroup, OutcomeMetric, Presentation
from prp_gym.evaluation.metrics import register_metric

OUTCOME = MetricGroup("Outcome", 0.0)

register_metric(
    OutcomeMetric(
        "score",
        ("1",),
        "mean reward over the planned control periods, in [0, 1]; those after a divergence count as 0",
        (),
        lambda r: float(r.reward.sum() / r.planned_periods),
        Presentation(OUTCOME, higher_is_better=True),
    )
)
register_metric(
    OutcomeMetric(
        "divergence",
        ("%",),
        "share of episodes that ended in a divergence",
        (),
        lambda r: 100.0 * r.diverged,
        Presentation(OUTCOME),
    )
)
