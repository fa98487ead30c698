"""Tuning of the classical controllers with the budget of simulated steps that a learned agent had."""

from prp_gym.tuning.candidates import Candidates
from prp_gym.tuning.episodes import Episodes, EpisodeScores
from prp_gym.tuning.search_space import Parameter, SearchSpace
from prp_gym.tuning.stored_study import StoredStudy
from prp_gym.tuning.task import TuningTask
from prp_gym.tuning.trial import Trial
from prp_gym.tuning.tune import Tuned, make_candidates, start_gains, tune
from prp_gym.tuning.tuned_controller import (
    TunedController,
    Validation,
    list_tuned_controllers,
    load_tuned_controller,
)

__all__ = [
    "Candidates",
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
    "make_candidates",
    "start_gains",
    "tune",
]
