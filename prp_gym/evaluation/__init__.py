"""Evaluation: recorded episodes, metrics, statistics, results."""

from prp_gym.evaluation.column import Column
from prp_gym.evaluation.episode import record_episode
from prp_gym.evaluation.evaluate import Evaluation, evaluate
from prp_gym.evaluation.hierarchy import (
    bootstrap_crossed,
    bootstrap_difference,
    bootstrap_nested,
    bootstrap_tasks,
)
from prp_gym.evaluation.improvement import paired_probability_of_improvement, probability_of_improvement
from prp_gym.evaluation.metric import Metric, MetricGroup, Presentation
from prp_gym.evaluation.metrics import METRICS, episode_metrics, register_metric
from prp_gym.evaluation.profiles import Profile, performance_profile
from prp_gym.evaluation.rollout import Policy, Rollout
from prp_gym.evaluation.score_summary import ScoreSummary
from prp_gym.evaluation.statistics import (
    Estimate,
    bootstrap_interquartile_mean,
    bootstrap_mean,
    interquartile_mean,
    worst_twentieth,
)

__all__ = [
    "METRICS",
    "Column",
    "Estimate",
    "Evaluation",
    "Metric",
    "MetricGroup",
    "Policy",
    "Presentation",
    "Profile",
    "Rollout",
    "ScoreSummary",
    "bootstrap_crossed",
    "bootstrap_difference",
    "bootstrap_interquartile_mean",
    "bootstrap_mean",
    "bootstrap_nested",
    "bootstrap_tasks",
    "episode_metrics",
    "evaluate",
    "interquartile_mean",
    "paired_probability_of_improvement",
    "performance_profile",
    "probability_of_improvement",
    "record_episode",
    "register_metric",
    "worst_twentieth",
]
