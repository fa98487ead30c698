"""Joint-space PD control with feedforward of the inverse dynamics."""

from dataclasses import dataclass
from typing import Any, ClassVar

from prp_gym.baselines.base.policy import Observed, StaticBaseline
from prp_gym.baselines.base.settings import Settings, Vector
from prp_gym.baselines.base.spec import ControllerData, ControllerSpec, register_controller
from prp_gym.robot.arrays import Array, apply


@dataclass(frozen=True, eq=False)
class JointFeedforwardSettings(Settings):
    """Settings of `JointFeedforwardController`.

    Attributes:
        proportional_gain: K_P (joints), diagonal [N m/rad, N/m, N m/rad].
        derivative_gain: K_D (joints), diagonal [N m s/rad, N s/m, N m s/rad].
    """

    proportional_gain: Any
    derivative_gain: Any

    vectors: ClassVar = {
        "proportional_gain": Vector("joint", "N·m/rad, N/m, N·m/rad"),
        "derivative_gain": Vector("joint", "N·m·s/rad, N·s/m, N·m·s/rad"),
    }


class JointFeedforwardController(StaticBaseline[JointFeedforwardSettings]):
    """τ = B(q_d) q̈_d + n(q_d, q̇_d) + K_P q̃ + K_D (q̇_d - q̇), q̃ = q_d - q.

    n = C q̇ + F_v q̇ + F_s sign(q̇) + g is the bias force. The model is evaluated at the reference alone, so
    that the feedforward does not depend on sensor noise. With the exact model the reference is a trajectory
    of the closed loop, locally asymptotically stable for gains that are large enough.

    Source: [S] 8.5.
    """

    measured_fields = ("joint_position", "joint_velocity")
    settings_class = JointFeedforwardSettings

    def torque(self, observed: Observed) -> Array:
        """See the class."""
        position, velocity, acceleration = self.references.joint(observed)
        feedforward = apply(self.model.inertia_matrix(position), acceleration)
        feedforward = feedforward + self.model.bias_force(position, velocity)
        error, error_rate = position - observed["joint_position"], velocity - observed["joint_velocity"]
        feedback = self.settings.proportional_gain * error + self.settings.derivative_gain * error_rate
        torque: Array = feedforward + feedback
        return torque


register_controller(
    ControllerSpec(
        name="joint_feedforward",
        summary="joint-space PD with feedforward of the inverse dynamics",
        policy=JointFeedforwardController,
        data=ControllerData.beside(__file__),
        command_inputs=("joint_offset",),
    )
)
