"""Tasks: their declarations and parts, observation fields, reference trajectories, reward, scenarios."""

from prp_gym.tasks.fields import Field, ObservationLayout
from prp_gym.tasks.parts import (
    EpisodeStart,
    ErrorFunction,
    Reference,
    ResetOption,
    StartSampler,
    TaskParts,
    World,
    observed_layout,
)
from prp_gym.tasks.ranges import Range
from prp_gym.tasks.registration import list_envs, register_task
from prp_gym.tasks.reward import Reward, RewardTerm
from prp_gym.tasks.scenario import SCENARIOS, Scenario
from prp_gym.tasks.setup import TaskNumbers, TaskSetup
from prp_gym.tasks.spec import TASKS, Criterion, TaskEntry, TaskScoring, TaskSpec
from prp_gym.tasks.target_model import Displacement, TargetModel
from prp_gym.tasks.task import Task
from prp_gym.tasks.trajectory import Constant, QuinticWaypoints, Sine, SquareAcceleration, Trajectory

__all__ = [
    "SCENARIOS",
    "TASKS",
    "Constant",
    "Criterion",
    "Displacement",
    "EpisodeStart",
    "ErrorFunction",
    "Field",
    "ObservationLayout",
    "QuinticWaypoints",
    "Range",
    "Reference",
    "ResetOption",
    "Reward",
    "RewardTerm",
    "Scenario",
    "Sine",
    "SquareAcceleration",
    "StartSampler",
    "TargetModel",
    "Task",
    "TaskEntry",
    "TaskNumbers",
    "TaskParts",
    "TaskScoring",
    "TaskSetup",
    "TaskSpec",
    "Trajectory",
    "World",
    "list_envs",
    "observed_layout",
    "register_task",
]
