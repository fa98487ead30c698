"""Force control with an inner position loop."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from prp_gym.baselines.force_integral import ForceError
from prp_gym.baselines.force_loop import ForceLoop, ForceLoopSettings
from prp_gym.baselines.policy import LawState, Observed
from prp_gym.baselines.references import PoseReference

ORIGINS = ("start", "base")


@dataclass(frozen=True, eq=False, kw_only=True)
class ForceInnerPositionSettings(ForceLoopSettings):
    """Numbers of `ForceInnerPosition`, beside those of every force law.

    Attributes:
        origin: `start` lets the force error move the pose at the episode's start; `base` puts 0 in place of
            that pose's component along the force, so that x_F counts from the base frame.
    """

    origin: str = "start"

    choices: ClassVar = {**ForceLoopSettings.choices, "origin": ORIGINS}


class ForceInnerPosition(ForceLoop[ForceInnerPositionSettings]):
    """M_d ẍ = -K_D ẋ + K_P (x_F - x) by inverse dynamics, x_F = x_0 + n (K_F e + K_I ∫e dt)."""

    name = "force_inner_position"
    summary = "force control with an inner position loop"
    settings_class = ForceInnerPositionSettings

    def initial_state(self, observed: Observed) -> LawState:
        """As every force law's, and the pose at the start; see `Baseline.initial_state`."""
        return (*super().initial_state(observed), observed["end_effector_pose"].copy())

    def base_motion(self, observed: Observed, state: LawState, error: ForceError) -> PoseReference:
        """At rest where the episode started."""
        pose = state[-1]
        if self.settings.origin == "base":
            pose = pose.copy()
            pose[..., :3] -= error.axis * error.along(pose[..., :3])
        return PoseReference(pose, np.zeros(pose.shape), np.zeros(pose.shape))
