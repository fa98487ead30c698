"""The classical controllers as policies, one law a file."""

from prp_gym.baselines.joint_inverse_dynamics import JointInverseDynamics, JointInverseDynamicsSettings
from prp_gym.baselines.joint_pd import JointPD, JointPDSettings
from prp_gym.baselines.policy import Baseline, ControlInterface, StaticBaseline
from prp_gym.baselines.registry import BASELINES, list_baselines, make_baseline
from prp_gym.baselines.settings import Settings, Vector

__all__ = [
    "BASELINES",
    "Baseline",
    "ControlInterface",
    "JointInverseDynamics",
    "JointInverseDynamicsSettings",
    "JointPD",
    "JointPDSettings",
    "Settings",
    "StaticBaseline",
    "Vector",
    "list_baselines",
    "make_baseline",
]
