"""The Gymnasium environments, one task a file."""

from prp_gym.envs.base.force_task import ForceOptions
from prp_gym.envs.base.rendering_task import StiffnessOptions, TargetOptions
from prp_gym.envs.config import EnvConfig
from prp_gym.envs.core.loop import EpisodeLoop
from prp_gym.envs.environment import PRPEnv
from prp_gym.envs.loop_environment import EnvState
from prp_gym.envs.tasks.adaptive import AdaptiveEnv, AdaptiveOptions, AdaptiveTracking, AdaptiveVectorEnv
from prp_gym.envs.tasks.admittance import Admittance, AdmittanceEnv, AdmittanceOptions, AdmittanceVectorEnv
from prp_gym.envs.tasks.compliance import Compliance, ComplianceEnv, ComplianceVectorEnv
from prp_gym.envs.tasks.force import Force, ForceEnv, ForceVectorEnv
from prp_gym.envs.tasks.force_position import (
    ForcePosition,
    ForcePositionEnv,
    ForcePositionOptions,
    ForcePositionVectorEnv,
)
from prp_gym.envs.tasks.impedance import Impedance, ImpedanceEnv, ImpedanceVectorEnv
from prp_gym.envs.tasks.joint_regulation import JointRegulation, JointRegulationEnv, JointRegulationVectorEnv
from prp_gym.envs.tasks.joint_tracking import (
    JointTracking,
    JointTrackingEnv,
    JointTrackingVectorEnv,
    TrackingOptions,
)
from prp_gym.envs.tasks.pose_regulation import PoseRegulation, PoseRegulationEnv, PoseRegulationVectorEnv
from prp_gym.envs.tasks.pose_tracking import (
    PoseTracking,
    PoseTrackingEnv,
    PoseTrackingOptions,
    PoseTrackingVectorEnv,
)
from prp_gym.envs.vector import PRPVectorEnv, VectorState
from prp_gym.envs.view import EnvironmentView

__all__ = [
    "AdaptiveEnv",
    "AdaptiveOptions",
    "AdaptiveTracking",
    "AdaptiveVectorEnv",
    "Admittance",
    "AdmittanceEnv",
    "AdmittanceOptions",
    "AdmittanceVectorEnv",
    "Compliance",
    "ComplianceEnv",
    "ComplianceVectorEnv",
    "EnvConfig",
    "EnvState",
    "EnvironmentView",
    "EpisodeLoop",
    "Force",
    "ForceEnv",
    "ForceOptions",
    "ForcePosition",
    "ForcePositionEnv",
    "ForcePositionOptions",
    "ForcePositionVectorEnv",
    "ForceVectorEnv",
    "Impedance",
    "ImpedanceEnv",
    "ImpedanceVectorEnv",
    "JointRegulation",
    "JointRegulationEnv",
    "JointRegulationVectorEnv",
    "JointTracking",
    "JointTrackingEnv",
    "JointTrackingVectorEnv",
    "PRPEnv",
    "PRPVectorEnv",
    "PoseRegulation",
    "PoseRegulationEnv",
    "PoseRegulationVectorEnv",
    "PoseTracking",
    "PoseTrackingEnv",
    "PoseTrackingOptions",
    "PoseTrackingVectorEnv",
    "StiffnessOptions",
    "TargetOptions",
    "TrackingOptions",
    "VectorState",
]
