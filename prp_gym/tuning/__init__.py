"""Tuning of the classical laws with the budget of simulated steps that a learned agent had."""

from prp_gym.tuning.episodes import Episodes, EpisodeScores
from prp_gym.tuning.search_space import Parameter, SearchSpace
from prp_gym.tuning.stored_study import StoredStudy
from prp_gym.tuning.task import TuningTask
from prp_gym.tuning.trial import Trial
from prp_gym.tuning.tune import Tuned, search_space, start_gains, tune
from prp_gym.tuning.tuned_controller import (
    TunedController,
    Validation,
    list_tuned_controllers,
    load_tuned_controller,
)

__all__ = [
    "EpisodeScores",
    "Episodes",
    "Parameter",
    "SearchSpace",
    "StoredStudy",
    "Trial",
    "Tuned",
    "TunedController",
    "TuningTask",
    "Validation",
    "list_tuned_controllers",
    "load_tuned_controller",
    "search_space",
    "start_gains",
    "tune",
]
