"""Operational-space inverse dynamics control."""

from dataclasses import dataclass
from typing import Any, ClassVar

from prp_gym.baselines.base.operational import OperationalStaticBaseline
from prp_gym.baselines.base.policy import ControlInterface, Observed
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
        contact: `compensated` adds J_Aᵀh_A for the measured contact force, `ignored` nothing.
        joint_limits: `respected` commands no joint beyond its limit, `ignored` does not consider limits.
        pseudoinverse_damping: λ in J_A⁺ = (J_AᵀJ_A + λ²I)⁻¹J_Aᵀ [1]; J_A needs none.
    """

    proportional_gain: Any
    derivative_gain: Any
    contact: str = "ignored"
    joint_limits: str = "ignored"
    pseudoinverse_damping: float = 0.0

    vectors: ClassVar = {
        "proportional_gain": Vector("pose", "1/s²"),
        "derivative_gain": Vector("pose", "1/s"),
    }
    numbers: ClassVar = {"pseudoinverse_damping": ""}
    choices: ClassVar = {"contact": CONTACT_MODES, "joint_limits": LIMIT_MODES}


class OperationalInverseDynamicsController(OperationalStaticBaseline[OperationalInverseDynamicsSettings]):
    """τ = B(q) y + n(q, q̇) [+ J_Aᵀh_A], y = J_A⁺ (ẍ_d + K_D (ẋ_d - ẋ) + K_P x̃ - J̇_A q̇), x̃ = x_d - x.

    n = C q̇ + F_v q̇ + F_s sign(q̇) + g; h_A = (h_e, 0) is the measured force by the tip on the surface. With
    the exact model, and without contact or with it compensated, J_Aᵀ(x̃¨ + K_D x̃˙ + K_P x̃) = 0: six axes
    with natural frequency √K_P and damping ratio K_D/(2√K_P), to which three joints come as near as they can;
    exactly for equal gains on all axes and a small x̃ along an attainable reference. In continuous time the
    loop is stable near such a reference for equal positive gains; an error component that the arm cannot move
    (of a reference that it cannot attain) remains. Held over a period dt it needs, as in joint space, K_D dt
    < 2 and K_P dt < 2 K_D on every axis; the compensation, held too, and a one-step actuation delay lower
    these bounds. Far from its goal the controller may drive the slide against its stop; with the
    joint limits respected it continues with the other joints, otherwise it may remain there.

    Source: [S] 8.6.2; [R] 10.
    """

    settings_class = OperationalInverseDynamicsSettings

    def __init__(self, interface: ControlInterface, settings: OperationalInverseDynamicsSettings) -> None:
        super().__init__(interface, settings)
        if settings.contact == "compensated" and "contact_force" not in interface.layout.names:
            raise MissingFieldError(type(self).__name__, ["contact_force"], interface.layout.names)

    def torque(self, observed: Observed) -> Array:
        """See the class."""
        desired, state = self.desired(observed), self.measured(observed)
        acceleration = (
            desired.acceleration
            + self.settings.derivative_gain * (desired.velocity - state.velocity)
            + self.settings.proportional_gain * (desired.pose - state.pose)
        )
        resolve = self.resolved_torque if self.settings.joint_limits == "ignored" else self.limited_torque
        torque = resolve(state, acceleration, self.settings.pseudoinverse_damping)
        if self.settings.contact == "ignored":
            return torque
        return torque + self.contact_torque(state, observed["contact_force"])


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
