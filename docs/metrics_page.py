"""The page on metrics, and on the errors against which rewards are checked."""

from docs.tables import NOTE, table
from prp_gym.comparison.audit import LEAST_CORRELATION, LEAST_POLICIES, STANDARD_ERRORS
from prp_gym.evaluation.failure import MOST_FORCE
from prp_gym.evaluation.metric import Metric
from prp_gym.evaluation.metrics import METRICS
from prp_gym.evaluation.scoring import scoring_of
from prp_gym.tasks.registration import list_envs

_SCORES = f"""\
The score of an episode is its return over its duration. Tables of scores show

- **score**: the mean over the episodes with a 95 % bootstrap interval. Policies are ranked by it: one
  that fails in a quarter of the episodes loses a quarter of the score.
- **interquartile mean**: the mean of the middle half. It is robust to outliers, and hides failures.
- **worst twentieth**: the mean of the worst 5 % of the episodes, rounded down, of one at least.
- **skill**: (score - floor)/(1 - floor) with the better of two floors: `zero_torque`, and `hold`, which
  keeps the start pose by inverse dynamics on the nominal model. Floors stand in every table after the
  other policies.
- **failed**: the share of episodes with each kind of failure. An episode has the first that applies, or
  none:
  1. diverged: the simulation ended early.
  2. excess force: the peak of the contact force is above {MOST_FORCE:g} times the desired force;
     without a desired force, above the task's bound.
  3. limit cycle: in the second half of the episode a deviation makes at least three full oscillations,
     and twice as many as the reference; in the last quarter they are larger than the tolerance of
     settling, and at least half as large as in the quarter before.
  4. unsettled: the responses are not within the tolerances of settling over the last tenth, of the
     episode or, for tasks whose tolerances say so, before the planned reference turns back.
"""

_METRIC_HEADERS = ("metric", "unit", "definition", "known as", "better", "requires")


def metrics_page() -> str:
    """Every metric with unit and definition, by the quantity that it measures."""
    text = (
        "A metric exists for an episode that has the fields and cost terms which it requires. Metrics of"
        " joints have one number per joint. Tables show medians of the metrics that the task declares. If the"
        " simulation diverged, all metrics but those of the outcome are undefined. A settling time that was"
        " not reached is infinite.\n"
    )
    parts = [NOTE, "# Metrics\n", text, "## Scores and failures\n", _SCORES, "## Settling\n", _settling()]
    for heading in dict.fromkeys(metric.group for metric in METRICS.values()):
        metrics = (metric for metric in METRICS.values() if metric.group == heading)
        parts += [f"## {heading}\n", table(_METRIC_HEADERS, map(_metric, metrics))]
    parts += ["## Criteria of the audit\n", _criteria()]
    return "\n".join(parts)


def _settling() -> str:
    """When the responses of each task count as settled."""
    rows = []
    for environment_id in list_envs():
        criterion = scoring_of(environment_id).settling
        if criterion is not None:
            rows.append((f"`{environment_id}`", criterion.definition))
    text = (
        "Every task declares the tolerances within which its responses count as settled:"
        " `response_settling_time` is when they are within them for good, and infinite if they are not over"
        " the last tenth of the episode. 0.2 N is what the force sensor of scenario `realistic` can tell: its"
        " bias is up to 0.1 N on each axis, 0.17 N along an oblique normal.\n\n"
    )
    return text + table(("environment", "settled"), rows)


def _criteria() -> str:
    """By which criteria `prp-gym audit` judges the score."""
    rows = [
        (f"`{environment_id}`", f"`{criterion.metric}`", f"{criterion.worst:g}")
        for environment_id in list_envs()
        for criterion in scoring_of(environment_id).criteria
    ]
    text = (
        "`prp-gym audit` computes Goodman and Kruskal's γ between the mean score and the smallness of each"
        " criterion below: the rank correlation over every two policies that the criterion distinguishes"
        f" by more than {STANDARD_ERRORS:g} standard errors of their mean difference over the episodes, of at"
        f" least {LEAST_POLICIES} good and bad ones, with a 95 % bootstrap interval over the episodes."
        " It has to exceed"
        f" {LEAST_CORRELATION:g}, and no policy of the best tenth by score may be in the worse half by a"
        " criterion. An episode that does not settle counts as the largest value that a criterion has, as"
        " does every value beyond it: nothing is gained by not doing what the task asks. No criterion is one"
        " of the reward's own signals. Energies are reported.\n\n"
    )
    return text + table(("environment", "criterion", "largest value"), rows)


def _metric(metric: Metric) -> tuple[str, ...]:
    return (
        f"`{metric.name}`",
        ", ".join(metric.units),
        metric.definition,
        metric.known_as,
        "higher" if metric.higher_is_better else "lower",
        ", ".join(f"`{name}`" for name in metric.requires),
    )
