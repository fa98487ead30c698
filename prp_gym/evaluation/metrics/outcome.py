"""Metrics of the outcome of an episode: its score, and whether it ended in a divergence."""

from prp_gym.evaluation.metric import MetricGroup, OutcomeMetric, Presentation
from prp_gym.evaluation.metrics import register_metric

OUTCOME = MetricGroup("Outcome", 0.0)

register_metric(
    OutcomeMetric(
        "score",
        ("1",),
        "return over duration, in [0, 1]; the time after a divergence counts as 0",
        (),
        lambda r: float(r.reward.sum() / r.duration),
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
