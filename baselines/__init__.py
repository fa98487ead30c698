"""The classical controllers as policies: each file declares one, beside the TOML file of its numbers."""

import warnings
from typing import Any

from prp_gym.baselines.adaptive import AdaptiveController, AdaptiveSettings
from prp_gym.baselines.admittance import AdmittanceController, AdmittanceSettings
from prp_gym.baselines.base.control_interface import ControlInterface
from prp_gym.baselines.base.force_loop import ForceLoopSettings
from prp_gym.baselines.base.function_controller import FunctionControllerSpec, controller
from prp_gym.baselines.base.gains import gain_sets, load_gains
from prp_gym.baselines.base.make import list_baselines, make_baseline, make_controller
from prp_gym.baselines.base.operational import OperationalBaseline, OperationalStaticBaseline
from prp_gym.baselines.base.policy import Baseline, StaticBaseline
from prp_gym.baselines.base.settings import Settings, Vector
from prp_gym.baselines.base.spec import CONTROLLERS, ControllerData, ControllerSpec, register_controller
from prp_gym.baselines.compliance import ComplianceController, ComplianceSettings
from prp_gym.baselines.force_feedforward import ForceFeedforwardController, ForceFeedforwardSettings
from prp_gym.baselines.force_inner_position import ForceInnerPositionController, ForceInnerPositionSettings
from prp_gym.baselines.impedance import ImpedanceController, ImpedanceSettings
from prp_gym.baselines.joint_inverse_dynamics import (
    JointInverseDynamicsController,
    JointInverseDynamicsSettings,
)
from prp_gym.baselines.joint_pd import JointPDController, JointPDSettings
from prp_gym.baselines.model_predictive import ModelPredictiveController, ModelPredictiveSettings
from prp_gym.baselines.operational_inverse_dynamics import (
    OperationalInverseDynamicsController,
    OperationalInverseDynamicsSettings,
)
from prp_gym.baselines.operational_pd import OperationalPDController, OperationalPDSettings
from prp_gym.baselines.parallel_force_position import ParallelForcePositionController
from prp_gym.baselines.time_optimal import TimeOptimalController, TimeOptimalSettings

BASELINES = CONTROLLERS
"""The declared controllers by name; the same as `CONTROLLERS`."""

__all__ = [
    "BASELINES",
    "CONTROLLERS",
    "AdaptiveController",
    "AdaptiveSettings",
    "AdmittanceController",
    "AdmittanceSettings",
    "Baseline",
    "ComplianceController",
    "ComplianceSettings",
    "ControlInterface",
    "ControllerData",
    "ControllerSpec",
    "ForceFeedforwardController",
    "ForceFeedforwardSettings",
    "ForceInnerPositionController",
    "ForceInnerPositionSettings",
    "ForceLoopSettings",
    "FunctionControllerSpec",
    "ImpedanceController",
    "ImpedanceSettings",
    "JointInverseDynamicsController",
    "JointInverseDynamicsSettings",
    "JointPDController",
    "JointPDSettings",
    "ModelPredictiveController",
    "ModelPredictiveSettings",
    "OperationalBaseline",
    "OperationalInverseDynamicsController",
    "OperationalInverseDynamicsSettings",
    "OperationalPDController",
    "OperationalPDSettings",
    "OperationalStaticBaseline",
    "ParallelForcePositionController",
    "Settings",
    "StaticBaseline",
    "TimeOptimalController",
    "TimeOptimalSettings",
    "Vector",
    "controller",
    "gain_sets",
    "list_baselines",
    "load_gains",
    "make_baseline",
    "make_controller",
    "register_controller",
]

_RENAMED = (
    "Adaptive",
    "Admittance",
    "Compliance",
    "ForceInnerPosition",
    "Impedance",
    "JointInverseDynamics",
    "JointPD",
    "OperationalInverseDynamics",
    "OperationalPD",
    "ParallelForcePosition",
)


def __getattr__(name: str) -> Any:
    """The names that the controllers' classes had in version 0.1."""
    if name not in _RENAMED:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    message = f"{__name__}.{name} is now called {name}Controller; the old name is kept for one release"
    warnings.warn(message, DeprecationWarning, stacklevel=2)
    return globals()[f"{name}Controller"]
