"""Operational-space inverse dynamics control."""

from dataclasses import dataclass
from typing import Any, ClassVar

from prp_gym.baselines.base.control_interface import ControlInterface
from prp_gym.baselines.base.error_integral import ErrorIntegral
from prp_gym.baselines.base.operational import OperationalBaseline
from prp_gym.baselines.base.policy import ControllerState, Observed
from prp_gym.baselines.base.settings import Settings, Vector
from prp_gym.baselines.base.spec import ControllerData, ControllerSpec, register_controller
from prp_gym.errors import MissingFieldError
from prp_gym.robot.arrays import Array

CONTACT_MODES = ("ignored", "compensated")
LIMIT_MODES = ("ignored", "respected")


@dataclass(frozen=True, eq=False)
class OperationalInverseDynamicsSettings(Settings):
    """Settings of `OperationalInverseDynamicsController`.

    Attributes:
        proportional_gain: K_P (6), diagonal [1/s^2].
        derivative_gain: K_D (6), diagonal [1/s].
        integral_gain: K_I (6), diagonal [1/s^3].
        contact: `compensated` adds J_Aᵀh_A for the measured contact force, `ignored` nothing.
        joint_limits: `respected` commands no joint beyond its limit, `ignored` does not consider limits.
        pseudoinverse_damping: λ in J_A⁺ = (J_AᵀJ_A + λ²I)⁻¹J_Aᵀ [1]; J_A needs none.
    """

    proportional_gain: Any
    derivative_gain: Any
    integral_gain: Any = 0.0
    contact: str = "ignored"
    joint_limits: str = "ignored"
    pseudoinverse_damping: float = 0.0

    vectors: ClassVar = {
        "proportional_gain": Vector("pose", "1/s²"),
        "derivative_gain": Vector("pose", "1/s"),
        "integral_gain": Vector("pose", "1/s³"),
    }
    numbers: ClassVar = {"pseudoinverse_damping": ""}
    choices: ClassVar = {"contact": CONTACT_MODES, "joint_limits": LIMIT_MODES}


class OperationalInverseDynamicsController(OperationalBaseline[OperationalInverseDynamicsSettings]):
    """τ = B(q) y + n(q, q̇) [+ J_Aᵀh_A], y = J_A⁺ (a - J̇_A q̇), a = ẍ_d + K_D x̃˙ + K_P x̃ + K_I ∫x̃ dt.

    x̃ = x_d - x; n = C q̇ + F_v q̇ + F_s sign(q̇) + g; h_A = (h_e, 0) is the measured force by the tip on
    the surface. With the exact model, K_I = 0, and without contact or with it compensated, J_Aᵀ(x̃¨ + K_D
    x̃˙ + K_P x̃) = 0: six axes with natural frequency √K_P and damping ratio K_D/(2√K_P), to which three
    joints come as near as they can; exactly for equal gains on all axes and a small x̃ along an
    attainable reference. In continuous time the loop is stable near such a reference for equal positive
    gains; an error component that the arm cannot move (of a reference that it cannot attain) remains.
    Held over a period dt it needs, as in joint space, K_D dt < 2 and K_P dt < 2 K_D on every axis; the
    compensation, held too, and a one-step actuation delay lower these bounds. Integral action removes a
    constant error that the arm can move, and needs K_I < K_D K_P on every axis (Routh criterion) in
    continuous time; docs/theory.md gives the sampled limits. It is held while an actuator is at its
    limit; an error that the arm cannot move is integrated too, so that it is meant for attainable
    references. Far from its goal the controller may drive the slide against its stop; with the joint
    limits respected it continues with the other joints, otherwise it may remain there.

    Source: [S] 8.6.2; [R] 10.
    """

    settings_class = OperationalInverseDynamicsSettings
    integrators = (0,)

    def __init__(self, interface: ControlInterface, settings: OperationalInverseDynamicsSettings) -> None:
        super().__init__(interface, settings)
        if settings.contact == "compensated" and "contact_force" not in interface.layout.names:
            raise MissingFieldError(type(self).__name__, ["contact_force"], interface.layout.names)
        self._integral = ErrorIntegral.of(self.settings.integral_gain, interface.period)

    def initial_state(self, observed: Observed) -> ControllerState:
        """K_I ∫x̃ dt (..., 6), zero at the start of an episode; no state if K_I is zero."""
        return self._integral.begin(observed["end_effector_pose"].shape)

    def control(self, observed: Observed, state: ControllerState) -> tuple[Array, ControllerState]:
        """See the class."""
        desired, measured = self.desired(observed), self.measured(observed)
        error = desired.pose - measured.pose
        acceleration = (
            desired.acceleration
            + self.settings.derivative_gain * (desired.velocity - measured.velocity)
            + self.settings.proportional_gain * error
        )
        acceleration, after = self._integral.step(acceleration, error, state)
        resolve = self.resolved_torque if self.settings.joint_limits == "ignored" else self.limited_torque
        torque = resolve(measured, acceleration, self.settings.pseudoinverse_damping)
        if self.settings.contact == "ignored":
            return torque, after
        return torque + self.contact_torque(measured, observed["contact_force"]), after


register_controller(
    ControllerSpec(
        name="operational_inverse_dynamics",
        summary="operational-space inverse dynamics, with or without compensation of the contact force",
        policy=OperationalInverseDynamicsController,
        data=ControllerData.beside(__file__),
        command_inputs=("pose_offset",),
        chapter=10,
    )
)
