"""The page on metrics, and on the errors against which rewards are checked."""

from docs.tables import NOTE, table
from prp_gym.comparison.audit import LEAST_CORRELATION
from prp_gym.comparison.task_error import TASK_ERRORS
from prp_gym.evaluation.metric import Metric
from prp_gym.evaluation.metrics import GROUPS

_METRIC_HEADERS = ("metric", "unit", "definition", "known as", "better", "requires")


def metrics_page() -> str:
    """Every metric with unit and definition, by the kind of question that it answers."""
    text = (
        "A metric exists for an episode that has the fields and cost terms which it requires. Joint-wise"
        " metrics have one number a joint. Tables show the interquartile mean of the score with a 95 %"
        " bootstrap interval over the episodes, and medians of the rest. After a divergence only the score"
        " and the divergence count. A settling time that was not reached is infinite.\n"
    )
    parts = [NOTE, "# Metrics\n", text]
    for heading, metrics in GROUPS.items():
        parts += [f"## {heading}\n", table(_METRIC_HEADERS, map(_metric, metrics))]
    parts += ["## Physical errors\n", _physical_errors()]
    return "\n".join(parts)


def _physical_errors() -> str:
    """Against which errors `prp-gym compare` checks the rewards, and why these."""
    rows = []
    for environment_id, task_error in TASK_ERRORS.items():
        units = "; ".join(", ".join(f"{value:g}" for value in scale) for scale in task_error.parts.values())
        rows.append((f"`{environment_id}`", task_error.name, units, task_error.reason))
    text = (
        "`prp-gym compare` tells the rank correlation between score and smallness of a physical error, over"
        " all policies of a task and scenario, with a 95 % bootstrap interval over the episodes, flagged"
        f" below {LEAST_CORRELATION:g}; `--audit` adds every law with its other gain sets, as policies that"
        " hardly differ tell nothing. The error is the sum of these metrics, each in units of what counts the"
        " same (SI units), and, as the score, its interquartile mean over the episodes; after a divergence it"
        " is infinite.\n\n"
        "All are means over time of absolute errors: they count how large an error is as well as how long it"
        " lasts, and have neither the scales nor the kernel of the reward. A root mean square would be that"
        " of one impact, or of the first distance to the goal, which is the same for all policies; a median"
        " would leave out what takes less than half of the time, as contact may; an error after the transient"
        " would leave out the transient.\n\n"
    )
    return text + table(("environment", "error", "in units of", "why"), rows)


def _metric(metric: Metric) -> tuple[str, ...]:
    return (
        f"`{metric.name}`",
        ", ".join(metric.units),
        metric.definition,
        metric.known_as,
        "higher" if metric.higher_is_better else "lower",
        ", ".join(f"`{name}`" for name in metric.requires),
    )
