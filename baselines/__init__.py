"""The classical controllers as policies, one law a file."""

from prp_gym.baselines.joint_inverse_dynamics import JointInverseDynamics, JointInverseDynamicsSettings
from prp_gym.baselines.joint_pd import JointPD, JointPDSettings
from prp_gym.baselines.policy import Baseline, ControlInterface, ModelBaseline, ModelSettings, Settings
from prp_gym.baselines.registry import BASELINES, list_baselines, make_baseline

__all__ = [
    "BASELINES",
    "Baseline",
    "ControlInterface",
    "JointInverseDynamics",
    "JointInverseDynamicsSettings",
    "JointPD",
    "JointPDSettings",
    "ModelBaseline",
    "ModelSettings",
    "Settings",
    "list_baselines",
    "make_baseline",
]
