"""Tuning of the classical laws with the budget of simulated steps that a learned agent had."""

from prp_gym.tuning.episodes import Episodes, Played
from prp_gym.tuning.search_space import Parameter, SearchSpace
from prp_gym.tuning.stored_study import StoredStudy
from prp_gym.tuning.task import TuningTask
from prp_gym.tuning.trial import Trial
from prp_gym.tuning.tune import Tuned, search_space, start_gains, tune
from prp_gym.tuning.tuned_law import TunedLaw, Validation, list_tuned_laws, load_tuned_law

__all__ = [
    "Episodes",
    "Parameter",
    "Played",
    "SearchSpace",
    "StoredStudy",
    "Trial",
    "Tuned",
    "TunedLaw",
    "TuningTask",
    "Validation",
    "list_tuned_laws",
    "load_tuned_law",
    "search_space",
    "start_gains",
    "tune",
]
