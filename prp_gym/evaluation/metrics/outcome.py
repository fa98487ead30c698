"""Metrics of the outcome of an episode: its score, whether and when it settled, and how it failed."""

import numpy as np

from prp_gym.evaluation.column import Column
from prp_gym.evaluation.failure import failure_shares
from prp_gym.evaluation.metric import MetricGroup, OutcomeMetric, Presentation
from prp_gym.evaluation.metrics import register_metric
from prp_gym.evaluation.rollout import Rollout
from prp_gym.evaluation.scoring import Settling, settling_of

OUTCOME = MetricGroup("Outcome", 0.0)


class SettlingMetric(OutcomeMetric):
    """A metric of episodes whose task declares when its responses count as settled."""

    def exists(self, rollout: Rollout) -> bool:
        """Whether the task of an episode declares a settling criterion whose fields the episode has."""
        return settling_of(rollout) is not None


def response_settling_time(rollout: Rollout) -> float:
    """When the responses of an episode come within the task's tolerances for good [s].

    Infinite if they are not within them over the last tenth of the planned episode, as after a divergence,
    nor, where the task asks for it, over the last tenth before its planned reference turns back.
    """
    criterion = settling_of(rollout)
    if criterion is None or rollout.diverged:
        return np.inf
    return Settling.of(rollout, criterion).time


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
register_metric(
    SettlingMetric(
        "response_settling_time",
        ("s",),
        "when the responses are within the task's tolerances for good, at least over the last tenth",
        (),
        response_settling_time,
        Presentation(OUTCOME, Column("set\u00adtling time", ("s",)), "settling time"),
    )
)
register_metric(
    SettlingMetric(
        "unsettled",
        ("%",),
        "share of episodes whose responses do not settle, for whatever reason",
        (),
        lambda r: 100.0 * np.isinf(response_settling_time(r)),
        Presentation(OUTCOME),
    )
)
register_metric(
    OutcomeMetric(
        "failure",
        ("%", "%", "%", "%"),
        "share of episodes that diverged; else pressed too hard; else oscillated to the end; else did not"
        " settle",
        (),
        failure_shares,
        Presentation(OUTCOME),
    )
)
