"""The floor `zero_torque`: all torques are zero."""

from dataclasses import dataclass

import numpy as np

from prp_gym.baselines.base.policy import Observed, StaticBaseline
from prp_gym.baselines.base.settings import Settings
from prp_gym.baselines.base.spec import ControllerSpec
from prp_gym.robot.arrays import Array
from prp_gym.tasks.fields import ObservationLayout


@dataclass(frozen=True, eq=False)
class ZeroTorqueSettings(Settings):
    """Settings of `ZeroTorqueFloor`: none but the model, which it does not use."""


class ZeroTorqueFloor(StaticBaseline[ZeroTorqueSettings]):
    """τ = 0: the arm moves as gravity and contact move it."""

    measured_fields = ("joint_position",)
    settings_class = ZeroTorqueSettings

    @classmethod
    def missing_fields(cls, layout: ObservationLayout) -> list[str]:
        """See `Baseline.missing_fields`; no reference is read."""
        return [name for name in cls.measured_fields if name not in layout.names]

    def torque(self, observed: Observed) -> Array:
        """See the class."""
        return np.zeros(observed["joint_position"].shape)


ZERO_TORQUE = ControllerSpec(
    name="zero_torque", summary="floor: all torques are zero", policy=ZeroTorqueFloor
)
