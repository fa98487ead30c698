"""Parallel force/position control."""

from prp_gym.baselines.base.force_integral import ForceError
from prp_gym.baselines.base.force_loop import FORCE_COMMAND_INPUTS, ForceLoop, ForceLoopSettings
from prp_gym.baselines.base.policy import ControllerState, Observed
from prp_gym.baselines.base.references import PoseReference
from prp_gym.baselines.base.spec import ControllerData, ControllerSpec, register_controller


class ParallelForcePositionController(ForceLoop[ForceLoopSettings]):
    """a = ẍ_d + M_d⁻¹(K_D (ẋ_d - ẋ) + K_P (x_d + x_F - x)), x_F = n (K_F e + K_I ∫e dt).

    Like `ForceInnerPositionController`, but around the desired motion: across n = f_d/|f_d| the tip follows
    x_d; along n the integral dominates K_P and the force is f_d at rest, x = x_d + x_F. The stability bounds
    are the same, by Routh K K_I < (K_D/M_d)(1 + K K_F) and, held over dt, K_P (1 + K K_F) dt < 2 K_D: 100 N/m
    at 500 Hz with the report's gains. A motion of x_d along n disturbs the force, and in the estimated form
    must stay slower than its v.

    Source: [S] 9.4.3; [R] 15.
    """

    settings_class = ForceLoopSettings

    def base_motion(self, observed: Observed, state: ControllerState, error: ForceError) -> PoseReference:
        """The desired motion."""
        return self.desired(observed)


register_controller(
    ControllerSpec(
        name="parallel_force_position",
        summary="parallel force/position control",
        policy=ParallelForcePositionController,
        data=ControllerData.beside(__file__),
        command_inputs=("pose_offset", *FORCE_COMMAND_INPUTS),
        chapter=15,
        revision=2,
    )
)
