"""The Gymnasium environments, one task a file."""

from prp_gym.envs.config import EnvConfig
from prp_gym.envs.environment import EnvState, PRPEnv
from prp_gym.envs.joint_regulation import JointRegulation, JointRegulationEnv
from prp_gym.envs.joint_tracking import JointTracking, JointTrackingEnv, TrackingOptions
from prp_gym.envs.loop import EpisodeLoop

__all__ = [
    "EnvConfig",
    "EnvState",
    "EpisodeLoop",
    "JointRegulation",
    "JointRegulationEnv",
    "JointTracking",
    "JointTrackingEnv",
    "PRPEnv",
    "TrackingOptions",
]
