"""The page on metrics, and on the errors against which rewards are checked."""

from docs.tables import NOTE, table
from prp_gym.comparison.audit import LEAST_CORRELATION
from prp_gym.evaluation.metric import Metric
from prp_gym.evaluation.metrics import METRICS
from prp_gym.evaluation.scoring import scoring_of
from prp_gym.tasks.registration import list_envs

_METRIC_HEADERS = ("metric", "unit", "definition", "known as", "better", "requires")


def metrics_page() -> str:
    """Every metric with unit and definition, by the quantity that it measures."""
    text = (
        "A metric exists for an episode that has the fields and cost terms which it requires. Metrics of"
        " joints have one number per joint. Tables show the interquartile mean of the score with a 95 %"
        " bootstrap interval over the episodes, and medians of the other metrics that the task declares. If"
        " the simulation diverged, all metrics but the score and the divergence are undefined. A settling"
        " time that was not reached is infinite.\n"
    )
    parts = [NOTE, "# Metrics\n", text]
    for heading in dict.fromkeys(metric.group for metric in METRICS.values()):
        metrics = (metric for metric in METRICS.values() if metric.group == heading)
        parts += [f"## {heading}\n", table(_METRIC_HEADERS, map(_metric, metrics))]
    parts += ["## Physical errors\n", _physical_errors()]
    return "\n".join(parts)


def _physical_errors() -> str:
    """Against which errors `prp-gym compare` checks the rewards, and why these."""
    rows = []
    for environment_id in list_envs():
        error = scoring_of(environment_id).error
        if error is not None:
            units = "; ".join(", ".join(f"{value:g}" for value in scale) for scale in error.parts.values())
            rows.append((f"`{environment_id}`", error.name, units, error.reason))
    text = (
        "`prp-gym compare` computes the rank correlation between the score and the smallness of a physical"
        " error, over all policies of a task and scenario, with a 95 % bootstrap interval over the episodes,"
        f" and flags it below {LEAST_CORRELATION:g}. `--audit` adds every controller with its other gain"
        " sets, because a correlation over policies that hardly differ is left to chance. The error is the"
        " sum of the metrics below, each divided by the value that counts as 1 (SI units). As for the score,"
        " its interquartile mean over the episodes is taken; after a divergence it is infinite. A task that"
        " declares no error is left out.\n\n"
        "Every error is a mean over time of absolute errors: it counts how large an error is as well as how"
        " long it lasts, and has neither the scales nor the kernel of the reward. A root mean square would be"
        " dominated by one impact, or by the initial distance to the goal, which is the same for all"
        " policies; a median would leave out whatever takes less than half of the time, as contact may; an"
        " error after the transient would leave out the transient.\n\n"
    )
    return text + table(("environment", "error", "value that counts as 1", "reason"), rows)


def _metric(metric: Metric) -> tuple[str, ...]:
    return (
        f"`{metric.name}`",
        ", ".join(metric.units),
        metric.definition,
        metric.known_as,
        "higher" if metric.higher_is_better else "lower",
        ", ".join(f"`{name}`" for name in metric.requires),
    )
