"""Joint-space inverse dynamics control (computed torque)."""

from dataclasses import dataclass
from typing import Any, ClassVar

from prp_gym.baselines.base.policy import Observed, StaticBaseline
from prp_gym.baselines.base.settings import Settings, Vector
from prp_gym.baselines.base.spec import ControllerData, ControllerSpec, register_controller
from prp_gym.robot.arrays import Array, apply


@dataclass(frozen=True, eq=False)
class JointInverseDynamicsSettings(Settings):
    """Settings of `JointInverseDynamicsController`.

    Attributes:
        proportional_gain: K_P (joints), diagonal [1/s^2].
        derivative_gain: K_D (joints), diagonal [1/s].
    """

    proportional_gain: Any
    derivative_gain: Any

    vectors: ClassVar = {
        "proportional_gain": Vector("joint", "1/s²"),
        "derivative_gain": Vector("joint", "1/s"),
    }


class JointInverseDynamicsController(StaticBaseline[JointInverseDynamicsSettings]):
    """τ = B(q) y + n(q, q̇), y = q̈_d + K_D (q̇_d - q̇) + K_P (q_d - q), n = C q̇ + F_v q̇ + F_s sign(q̇) + g.

    With the exact model every joint obeys q̃¨ + K_D q̃˙ + K_P q̃ = 0 on its own: natural frequency √K_P,
    damping ratio K_D/(2√K_P), stable for any positive gains in continuous time. Under an exact zero-order
    hold with period dt the double integrator needs K_D dt < 2 and K_P dt² < 2 K_D dt; the compensation, held
    too, and a one-step actuation delay lower these bounds. With an inaccurate model the error is bounded
    where the inertia estimate is near enough to the true one, but does not vanish.

    Source: [S] 8.5.2; [R] 7.
    """

    measured_fields = ("joint_position", "joint_velocity")
    settings_class = JointInverseDynamicsSettings

    def torque(self, observed: Observed) -> Array:
        """See the class."""
        desired = self.references.joint(observed)
        q, velocity = observed["joint_position"], observed["joint_velocity"]
        K_P, K_D = self.settings.proportional_gain, self.settings.derivative_gain
        acceleration = (
            desired.acceleration + K_D * (desired.velocity - velocity) + K_P * (desired.position - q)
        )
        return apply(self.model.inertia_matrix(q), acceleration) + self.model.bias_force(q, velocity)


register_controller(
    ControllerSpec(
        name="joint_inverse_dynamics",
        summary="joint-space inverse dynamics (computed torque)",
        policy=JointInverseDynamicsController,
        data=ControllerData.beside(__file__),
        command_inputs=("joint_offset",),
        chapter=7,
    )
)
