"""Parallel force/position control."""

from prp_gym.baselines.force_integral import ForceError
from prp_gym.baselines.force_loop import ForceLoop, ForceLoopSettings
from prp_gym.baselines.policy import LawState, Observed
from prp_gym.baselines.references import PoseReference


class ParallelForcePosition(ForceLoop[ForceLoopSettings]):
    """a = ẍ_d + M_d⁻¹(K_D (ẋ_d - ẋ) + K_P (x_d + x_F - x)), x_F = n (K_F e + K_I ∫e dt)."""

    name = "parallel_force_position"
    summary = "parallel force/position control"
    settings_class = ForceLoopSettings

    def base_motion(self, observed: Observed, state: LawState, error: ForceError) -> PoseReference:
        """The desired motion."""
        return self.desired(observed)
