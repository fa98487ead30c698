"""Joint-space sliding-mode control with a boundary layer."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from prp_gym.baselines.base.policy import Observed, StaticBaseline
from prp_gym.baselines.base.settings import Settings, Vector
from prp_gym.baselines.base.spec import ControllerData, ControllerSpec, register_controller
from prp_gym.robot.arrays import Array, apply


@dataclass(frozen=True, eq=False)
class SlidingModeSettings(Settings):
    """Settings of `SlidingModeController`.

    Attributes:
        slope: Λ (joints), rate at which the error vanishes on the sliding surface [1/s].
        reaching_gain: K (joints), acceleration towards the sliding surface [rad/s^2, m/s^2, rad/s^2].
        boundary_layer: φ (joints), thickness of the boundary layer [rad/s, m/s, rad/s].
    """

    slope: Any
    reaching_gain: Any
    boundary_layer: Any

    vectors: ClassVar = {
        "slope": Vector("joint", "1/s"),
        "reaching_gain": Vector("joint", "rad/s², m/s², rad/s²"),
        "boundary_layer": Vector("joint", "rad/s, m/s, rad/s", above_zero=True),
    }


class SlidingModeController(StaticBaseline[SlidingModeSettings]):
    """τ = B(q) (q̈_d + Λ q̃˙ + K sat(s/φ)) + n(q, q̇), s = q̃˙ + Λ q̃, q̃ = q_d - q.

    n = C q̇ + F_v q̇ + F_s sign(q̇) + g is the bias force, and sat clips to [-1, 1]. The sliding variable of
    every joint obeys ṡ = -K sat(s/φ) + d, where d is the acceleration that errors of the model leave
    uncompensated. If |d| <= D and K >= D + η with some η > 0, then d/dt s²/2 <= -η |s| outside the boundary
    layer, which is reached in at most |s(0)|/η. From then on |s| <= φ, and the error converges to
    |q̃| <= φ/Λ. With an exact model the error converges to zero for any positive Λ, K and φ. Inside the
    boundary layer the controller is linear, with the gains K_D = Λ + K/φ and K_P = Λ K/φ of inverse dynamics
    control; the control period dt therefore bounds K/φ: a zero-order hold needs (Λ + K/φ) dt < 2.

    Source: Slotine and Li, Applied Nonlinear Control, Prentice Hall, 1991, chapter 7.
    """

    measured_fields = ("joint_position", "joint_velocity")
    settings_class = SlidingModeSettings

    def torque(self, observed: Observed) -> Array:
        """See the class."""
        desired = self.references.joint(observed)
        q, velocity = observed["joint_position"], observed["joint_velocity"]
        error, error_rate = desired.position - q, desired.velocity - velocity
        sliding = error_rate + self.settings.slope * error
        switching = np.clip(sliding / self.settings.boundary_layer, -1.0, 1.0)
        acceleration = (
            desired.acceleration + self.settings.slope * error_rate + self.settings.reaching_gain * switching
        )
        return apply(self.model.inertia_matrix(q), acceleration) + self.model.bias_force(q, velocity)


CONTROLLER = register_controller(
    ControllerSpec(
        name="sliding_mode",
        summary="joint-space sliding-mode control with a boundary layer",
        policy=SlidingModeController,
        data=ControllerData.beside(__file__),
        command_inputs=("joint_offset",),
    )
)
