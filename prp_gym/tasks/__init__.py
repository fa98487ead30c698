"""The vocabulary of tasks: observation fields, reference trajectories, reward, scenarios."""

from prp_gym.tasks.fields import Field, ObservationLayout
from prp_gym.tasks.reward import Reward, RewardTerm
from prp_gym.tasks.scenario import SCENARIOS, Range, Scenario
from prp_gym.tasks.task import EpisodeStart, Task, TaskNumbers
from prp_gym.tasks.trajectory import Constant, QuinticWaypoints, Sine, Trajectory

__all__ = [
    "SCENARIOS",
    "Constant",
    "EpisodeStart",
    "Field",
    "ObservationLayout",
    "QuinticWaypoints",
    "Range",
    "Reward",
    "RewardTerm",
    "Scenario",
    "Sine",
    "Task",
    "TaskNumbers",
    "Trajectory",
]
