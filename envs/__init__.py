"""The Gymnasium environments, one task a file."""

from prp_gym.envs.adaptive import AdaptiveEnv, AdaptiveOptions, AdaptiveTracking
from prp_gym.envs.admittance import Admittance, AdmittanceEnv, AdmittanceOptions
from prp_gym.envs.compliance import Compliance, ComplianceEnv
from prp_gym.envs.config import EnvConfig
from prp_gym.envs.environment import EnvState, PRPEnv
from prp_gym.envs.force import Force, ForceEnv
from prp_gym.envs.force_position import ForcePosition, ForcePositionEnv, ForcePositionOptions
from prp_gym.envs.force_task import ForceOptions
from prp_gym.envs.impedance import Impedance, ImpedanceEnv
from prp_gym.envs.joint_regulation import JointRegulation, JointRegulationEnv
from prp_gym.envs.joint_tracking import JointTracking, JointTrackingEnv, TrackingOptions
from prp_gym.envs.loop import EpisodeLoop
from prp_gym.envs.pose_regulation import PoseRegulation, PoseRegulationEnv
from prp_gym.envs.pose_tracking import PoseTracking, PoseTrackingEnv, PoseTrackingOptions
from prp_gym.envs.rendering_task import StiffnessOptions, TargetOptions

__all__ = [
    "AdaptiveEnv",
    "AdaptiveOptions",
    "AdaptiveTracking",
    "Admittance",
    "AdmittanceEnv",
    "AdmittanceOptions",
    "Compliance",
    "ComplianceEnv",
    "EnvConfig",
    "EnvState",
    "EpisodeLoop",
    "Force",
    "ForceEnv",
    "ForceOptions",
    "ForcePosition",
    "ForcePositionEnv",
    "ForcePositionOptions",
    "Impedance",
    "ImpedanceEnv",
    "JointRegulation",
    "JointRegulationEnv",
    "JointTracking",
    "JointTrackingEnv",
    "PRPEnv",
    "PoseRegulation",
    "PoseRegulationEnv",
    "PoseTracking",
    "PoseTrackingEnv",
    "PoseTrackingOptions",
    "StiffnessOptions",
    "TargetOptions",
    "TrackingOptions",
]
