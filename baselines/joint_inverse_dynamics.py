"""Joint-space inverse dynamics control (computed torque)."""

from dataclasses import dataclass
from typing import Any, ClassVar

from prp_gym.baselines.base.control_interface import ControlInterface
from prp_gym.baselines.base.error_integral import ErrorIntegral
from prp_gym.baselines.base.policy import Baseline, ControllerState, Observed
from prp_gym.baselines.base.settings import Settings, Vector
from prp_gym.baselines.base.spec import ControllerData, ControllerSpec, register_controller
from prp_gym.robot.arrays import Array, apply


@dataclass(frozen=True, eq=False)
class JointInverseDynamicsSettings(Settings):
    """Settings of `JointInverseDynamicsController`.

    Attributes:
        proportional_gain: K_P (joints), diagonal [1/s^2].
        derivative_gain: K_D (joints), diagonal [1/s].
        integral_gain: K_I (joints), diagonal [1/s^3].
    """

    proportional_gain: Any
    derivative_gain: Any
    integral_gain: Any = 0.0

    vectors: ClassVar = {
        "proportional_gain": Vector("joint", "1/s²"),
        "derivative_gain": Vector("joint", "1/s"),
        "integral_gain": Vector("joint", "1/s³"),
    }


class JointInverseDynamicsController(Baseline[JointInverseDynamicsSettings]):
    """τ = B(q) y + n(q, q̇), y = q̈_d + K_D q̃˙ + K_P q̃ + K_I ∫q̃ dt, q̃ = q_d - q.

    n = C q̇ + F_v q̇ + F_s sign(q̇) + g. With the exact model and K_I = 0 every joint obeys q̃¨ + K_D q̃˙
    + K_P q̃ = 0 on its own: natural frequency √K_P, damping ratio K_D/(2√K_P), stable for any positive
    gains in continuous time. With integral action it is stable for K_I < K_D K_P (Routh criterion on s³ +
    K_D s² + K_P s + K_I). Under an exact zero-order hold with period dt the double integrator needs K_D
    dt < 2 and K_P dt² < 2 K_D dt; docs/theory.md gives the limits with integral action and with a
    one-step actuation delay, which lowers them, as does the compensation, held too. With an inaccurate model
    the error is bounded where the inertia estimate is near enough to the true one; a constant one
    vanishes only with integral action. The integral is held while an actuator is at its limit.

    Source: [S] 8.5.2; [R] 7.
    """

    measured_fields = ("joint_position", "joint_velocity")
    settings_class = JointInverseDynamicsSettings
    integrators = (0,)

    def __init__(self, interface: ControlInterface, settings: JointInverseDynamicsSettings) -> None:
        super().__init__(interface, settings)
        self._integral = ErrorIntegral.of(self.settings.integral_gain, interface.period)

    def initial_state(self, observed: Observed) -> ControllerState:
        """K_I ∫q̃ dt (..., joints), zero at the start of an episode; no state if K_I is zero."""
        return self._integral.begin(observed["joint_position"].shape)

    def control(self, observed: Observed, state: ControllerState) -> tuple[Array, ControllerState]:
        """See the class."""
        desired = self.references.joint(observed)
        q, velocity = observed["joint_position"], observed["joint_velocity"]
        K_P, K_D = self.settings.proportional_gain, self.settings.derivative_gain
        error = desired.position - q
        acceleration = desired.acceleration + K_D * (desired.velocity - velocity) + K_P * error
        acceleration, after = self._integral.step(acceleration, error, state)
        torque = apply(self.model.inertia_matrix(q), acceleration) + self.model.bias_force(q, velocity)
        return torque, after


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
