"""Force control with an inner position loop."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from prp_gym.baselines.base.force_integral import ForceError
from prp_gym.baselines.base.force_loop import FORCE_COMMAND_INPUTS, ForceLoop, ForceLoopSettings
from prp_gym.baselines.base.policy import ControllerState, Observed
from prp_gym.baselines.base.references import PoseReference
from prp_gym.baselines.base.spec import ControllerData, ControllerSpec, register_controller

ORIGINS = ("start", "base")


@dataclass(frozen=True, eq=False, kw_only=True)
class ForceInnerPositionSettings(ForceLoopSettings):
    """Settings of `ForceInnerPositionController`, beside those of every force controller.

    Attributes:
        origin: pose from which x_F is measured: `start` is the pose at the episode's start; in `base` its
            component along the force is 0, so that x_F is measured from the base frame.
    """

    origin: str = "start"

    choices: ClassVar = {**ForceLoopSettings.choices, "origin": ORIGINS}


class ForceInnerPositionController(ForceLoop[ForceInnerPositionSettings]):
    """M_d ẍ = -K_D ẋ + K_P (x_F - x) by inverse dynamics, x_F = x_0 + n (K_F e + K_I ∫e dt).

    n = f_d/|f_d| points into the surface, e = n·(f_d - f_e) with f_e by the tip on the surface, x_0 is the
    pose at the start. τ = B J_A⁺(ẍ - J̇_A q̇) + n(q, q̇) + Jᵀf_e compensates the contact force in the inner
    loop, which is therefore stable for all positive gains, and held over a period dt for K_D dt < 2 M_d
    (K_D dt < M_d with a one-step actuation delay). In contact with a spring K along n the loop is
    M_d s³ + K_D s² + K_P (1 + K K_F) s + K_P K K_I: by Routh it is stable for
    K K_I < (K_D/M_d)(1 + K K_F), without K_F for K K_I < K_D/M_d. Held over dt, K_P (1 + K K_F) dt must
    stay below 2 K_D too: the report's gains are stable up to 200 N/m at 500 Hz. A K_I that suits 50 N/m is
    therefore unstable on 5000 N/m, and one that suits 5000 N/m is a hundred times too slow on 50 N/m. The
    estimated form uses ω_c/K̂ in place of K_I, with K_F = 0, and predicts the force at which the inner loop
    comes to rest: with K̂ = K it is stable for every ω_c if K_D² > M_d K_P, however stiff the surface.

    Source: [S] 9.4.1; [R] 14.
    """

    settings_class = ForceInnerPositionSettings

    def initial_state(self, observed: Observed) -> ControllerState:
        """The state of every force controller, and the pose at the start; see `Baseline.initial_state`."""
        return (*super().initial_state(observed), observed["end_effector_pose"].copy())

    def base_motion(self, observed: Observed, state: ControllerState, error: ForceError) -> PoseReference:
        """The pose at the start of the episode, at rest."""
        pose = state[-1]
        if self.settings.origin == "base":
            pose = pose.copy()
            pose[..., :3] -= error.axis * error.along(pose[..., :3])
        return PoseReference(pose, np.zeros(pose.shape), np.zeros(pose.shape))


register_controller(
    ControllerSpec(
        name="force_inner_position",
        summary="force control with an inner position loop",
        policy=ForceInnerPositionController,
        data=ControllerData.beside(__file__),
        command_inputs=FORCE_COMMAND_INPUTS,
        chapter=14,
        revision=2,
    )
)
