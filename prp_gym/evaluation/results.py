"""Contents of a results file: the description of a run and of each evaluation."""

import os
import platform
from typing import Any

from prp_gym.artifacts import list_versions
from prp_gym.evaluation.evaluate import Evaluation
from prp_gym.evaluation.metrics import METRICS

SCHEMA = 2
"""Form of the results: 2 since `score` is the mean over the episodes; it was the interquartile mean."""


def describe_run(command: str) -> dict[str, Any]:
    """What a result depends on in addition to its settings: versions, machine, command."""
    return {
        "schema": SCHEMA,
        "command": command,
        "versions": list_versions(),
        "machine": {"system": platform.system(), "architecture": platform.machine(), "cores": os.cpu_count()},
        "units": {metric.name: metric.units for metric in METRICS.values()},
    }


def describe_evaluation(evaluation: Evaluation, baseline: str, settings: Any) -> dict[str, Any]:
    """One (environment, scenario, policy) of the results."""
    first = evaluation.rollouts[0]
    return {
        "environment": first.environment_id,
        "scenario": first.scenario,
        "engine": first.engine,
        "baseline": baseline,
        "settings": settings,
        "control_period": first.period,
        "duration": first.duration,
        "seeds": [rollout.seed for rollout in evaluation.rollouts],
        **evaluation.summary.to_plain(),
        "median": evaluation.median,
        "episodes": evaluation.metrics,
        "compute_time_per_step": evaluation.compute_time,
    }
