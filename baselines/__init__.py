"""The classical controllers as policies, one law a file."""

from prp_gym.baselines.adaptive import Adaptive, AdaptiveSettings
from prp_gym.baselines.admittance import Admittance, AdmittanceSettings
from prp_gym.baselines.compliance import Compliance, ComplianceSettings
from prp_gym.baselines.force_inner_position import ForceInnerPosition, ForceInnerPositionSettings
from prp_gym.baselines.force_loop import ForceLoopSettings
from prp_gym.baselines.impedance import Impedance, ImpedanceSettings
from prp_gym.baselines.joint_inverse_dynamics import JointInverseDynamics, JointInverseDynamicsSettings
from prp_gym.baselines.joint_pd import JointPD, JointPDSettings
from prp_gym.baselines.operational import OperationalBaseline, OperationalStaticBaseline
from prp_gym.baselines.operational_inverse_dynamics import (
    OperationalInverseDynamics,
    OperationalInverseDynamicsSettings,
)
from prp_gym.baselines.operational_pd import OperationalPD, OperationalPDSettings
from prp_gym.baselines.parallel_force_position import ParallelForcePosition
from prp_gym.baselines.policy import Baseline, ControlInterface, StaticBaseline
from prp_gym.baselines.registry import BASELINES, list_baselines, make_baseline
from prp_gym.baselines.settings import Settings, Vector

__all__ = [
    "BASELINES",
    "Adaptive",
    "AdaptiveSettings",
    "Admittance",
    "AdmittanceSettings",
    "Baseline",
    "Compliance",
    "ComplianceSettings",
    "ControlInterface",
    "ForceInnerPosition",
    "ForceInnerPositionSettings",
    "ForceLoopSettings",
    "Impedance",
    "ImpedanceSettings",
    "JointInverseDynamics",
    "JointInverseDynamicsSettings",
    "JointPD",
    "JointPDSettings",
    "OperationalBaseline",
    "OperationalInverseDynamics",
    "OperationalInverseDynamicsSettings",
    "OperationalPD",
    "OperationalPDSettings",
    "OperationalStaticBaseline",
    "ParallelForcePosition",
    "Settings",
    "StaticBaseline",
    "Vector",
    "list_baselines",
    "make_baseline",
]
