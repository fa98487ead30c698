"""The vocabulary of tasks: observation fields, reference trajectories, reward, scenarios."""

from prp_gym.tasks.fields import Field, ObservationLayout
from prp_gym.tasks.reward import Reward, RewardTerm
from prp_gym.tasks.scenario import SCENARIOS, Range, Scenario
from prp_gym.tasks.target_model import Displacement, TargetModel
from prp_gym.tasks.task import EpisodeStart, ResetOption, Task, TaskNumbers
from prp_gym.tasks.trajectory import Constant, QuinticWaypoints, Sine, SquareAcceleration, Trajectory

__all__ = [
    "SCENARIOS",
    "Constant",
    "Displacement",
    "EpisodeStart",
    "Field",
    "ObservationLayout",
    "QuinticWaypoints",
    "Range",
    "ResetOption",
    "Reward",
    "RewardTerm",
    "Scenario",
    "Sine",
    "SquareAcceleration",
    "TargetModel",
    "Task",
    "TaskNumbers",
    "Trajectory",
]
