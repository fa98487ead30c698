"""Search for the gains of the classical controllers with a budget of simulated steps, and its validation."""

from prp_gym.tuning.candidates import Candidates
from prp_gym.tuning.episodes import Episodes, EpisodeScores
from prp_gym.tuning.objective import CandidateScore, Objective, ScenarioCandidates
from prp_gym.tuning.search_space import Parameter, SearchSpace
from prp_gym.tuning.stored_scores import StoredScores
from prp_gym.tuning.stored_study import StoredStudy
from prp_gym.tuning.task import TuningTask
from prp_gym.tuning.trial import Trial
from prp_gym.tuning.tune import Tuned, make_candidates, start_gains, tune
from prp_gym.tuning.tuned_controller import TunedController, list_tuned_controllers, load_tuned_controller
from prp_gym.tuning.validation import Choice, Validation, choose
from prp_gym.tuning.widening import Ranges, ranges_after

__all__ = [
    "CandidateScore",
    "Candidates",
    "Choice",
    "EpisodeScores",
    "Episodes",
    "Objective",
    "Parameter",
    "Ranges",
    "ScenarioCandidates",
    "SearchSpace",
    "StoredScores",
    "StoredStudy",
    "Trial",
    "Tuned",
    "TunedController",
    "TuningTask",
    "Validation",
    "choose",
    "list_tuned_controllers",
    "load_tuned_controller",
    "make_candidates",
    "ranges_after",
    "start_gains",
    "tune",
]
