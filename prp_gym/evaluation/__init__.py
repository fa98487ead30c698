"""Evaluation: recorded episodes, metrics, statistics, results."""

from prp_gym.evaluation.evaluate import Evaluation, evaluate
from prp_gym.evaluation.metric import Metric
from prp_gym.evaluation.metrics import METRICS, episode_metrics
from prp_gym.evaluation.rollout import Policy, Rollout, record_episode
from prp_gym.evaluation.statistics import Estimate, bootstrap_interquartile_mean, interquartile_mean

__all__ = [
    "METRICS",
    "Estimate",
    "Evaluation",
    "Metric",
    "Policy",
    "Rollout",
    "bootstrap_interquartile_mean",
    "episode_metrics",
    "evaluate",
    "interquartile_mean",
    "record_episode",
]
