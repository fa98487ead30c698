"""The degenerate policy `maximum_torque`: every actuator at its limit."""

import numpy as np

from prp_gym.baselines.base.policy import Observed
from prp_gym.baselines.base.spec import ControllerSpec
from prp_gym.baselines.floors.zero_torque import ZeroTorqueFloor
from prp_gym.robot.arrays import Array


class MaximumTorquePolicy(ZeroTorqueFloor):
    """τ = τ_max in every joint."""

    def torque(self, observed: Observed) -> Array:
        """See the class."""
        return np.zeros(observed["joint_position"].shape) + self.interface.torque_limit


MAXIMUM_TORQUE = ControllerSpec(
    name="maximum_torque", summary="degenerate: every actuator at its limit", policy=MaximumTorquePolicy
)
