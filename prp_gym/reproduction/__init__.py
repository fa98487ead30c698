"""Reproduction of the report's experiments: figures, closed forms, measured values, verdicts."""

from prp_gym.reproduction.catalogue import Catalogue, load_catalogue
from prp_gym.reproduction.experiment import Answer, Check, Experiment, ExperimentRun, Level, Panel
from prp_gym.reproduction.outcome import FigureOutcome, Verdict, judge
from prp_gym.reproduction.run import RecordedRun, record_run

__all__ = [
    "Answer",
    "Catalogue",
    "Check",
    "Experiment",
    "ExperimentRun",
    "FigureOutcome",
    "Level",
    "Panel",
    "RecordedRun",
    "Verdict",
    "judge",
    "load_catalogue",
    "record_run",
]
