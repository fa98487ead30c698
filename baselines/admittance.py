"""Admittance control: the contact force displaces the desired motion, and the result is tracked."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from prp_gym.baselines.base.control_interface import ControlInterface
from prp_gym.baselines.base.error_integral import RunningIntegral
from prp_gym.baselines.base.force_sensing import ForceSensingSettings
from prp_gym.baselines.base.operational import MEASURED_MOTION, OperationalBaseline
from prp_gym.baselines.base.policy import ControllerState, Observed
from prp_gym.baselines.base.settings import Vector
from prp_gym.baselines.base.spec import ControllerData, ControllerSpec, register_controller
from prp_gym.robot.arrays import Array
from prp_gym.tasks.target_model import Displacement, TargetModel


@dataclass(frozen=True, eq=False, kw_only=True)
class AdmittanceSettings(ForceSensingSettings):
    """Settings of `AdmittanceController`.

    Attributes:
        inertia: M_t (pose) of the compliant frame, diagonal, above 0 [kg, kg, kg, kg m^2, kg m^2, kg m^2].
        damping: K_Dt (pose), diagonal [N s/m, N s/m, N s/m, N m s/rad, N m s/rad, N m s/rad].
        stiffness: K_Pt (pose), diagonal [N/m, N/m, N/m, N m/rad, N m/rad, N m/rad].
        proportional_gain: K_P (pose) of the motion control, diagonal [1/s^2].
        derivative_gain: K_D (pose) of the motion control, diagonal [1/s].
        integral_gain: K_I (pose) of the motion control, diagonal [1/s^3].
        pseudoinverse_damping: λ of J_A⁺, in the units of J_A's singular values.
    """

    inertia: Any
    damping: Any
    stiffness: Any
    proportional_gain: Any
    derivative_gain: Any
    integral_gain: Any = 0.0
    pseudoinverse_damping: float = 0.0

    vectors: ClassVar = {
        "inertia": Vector("pose", "kg, kg·m²"),
        "damping": Vector("pose", "N·s/m, N·m·s/rad"),
        "stiffness": Vector("pose", "N/m, N·m/rad"),
        "proportional_gain": Vector("pose", "1/s²"),
        "derivative_gain": Vector("pose", "1/s"),
        "integral_gain": Vector("pose", "1/s³"),
    }
    numbers: ClassVar = {**ForceSensingSettings.numbers, "pseudoinverse_damping": "1 (mixed units)"}


class AdmittanceController(OperationalBaseline[AdmittanceSettings]):
    """τ = B J_A⁺(a - J̇_A q̇) + n + Jᵀh_e, a = ẍ_t + K_D ẽ˙ + K_P ẽ + K_I ∫ẽ dt, ẽ = x_t - x, x_t = x_d - z.

    The compliant frame z obeys M_t z̈ + K_Dt ż + K_Pt z = h_A, h_A = (f_e, 0) by the tip on the surface, and
    is integrated exactly with the force held over a period; ẋ_t and ẍ_t come from it, not from differences.
    The torque compensates the contact force, so that the gains of the motion control are independent of the
    compliance: without integral action stable for all positive ones, and held over a period dt for
    K_D dt < 2, K_P dt² < 2 K_D dt (K_D dt < 1 with a one-step actuation delay). Integral action, held while
    an actuator is at its limit, removes what joint friction and errors of the model leave of ẽ, and needs
    K_I < K_D K_P (Routh criterion; docs/theory.md gives the sampled limits). On a spring K the tip obeys
    M_t ẍ + K_Dt ẋ + (K_Pt + K) x = K_Pt x_d + K x_e, stable for any K; the held force is half a period old on
    average, which reduces K_Dt by about K dt/2.

    Source: [S] 9.3.2; [R] 13.
    """

    measured_fields = (*MEASURED_MOTION, "contact_force")
    settings_class = AdmittanceSettings
    rendered = ("inertia", "damping", "stiffness")
    integrators = (0,)

    def __init__(self, interface: ControlInterface, settings: AdmittanceSettings) -> None:
        super().__init__(interface, settings)
        numbers = self.settings
        self.compliant_frame = TargetModel(
            numbers.inertia, numbers.damping, numbers.stiffness, interface.period
        )
        self._integral = RunningIntegral(numbers.integral_gain, interface.period)
        self._taring = numbers.make_taring(interface.period)

    def initial_state(self, observed: Observed) -> ControllerState:
        """K_I ∫(x_t - x) dt = 0, z = 0 and at rest, no tare yet; see `Baseline.initial_state`."""
        shape = observed["joint_position"].shape[:-1]
        integral = self._integral.begin(observed["end_effector_pose"].shape)
        return *integral, *Displacement.zero(shape), *self._taring.begin(shape)

    def control(self, observed: Observed, state: ControllerState) -> tuple[Array, ControllerState]:
        """See `Baseline.control`."""
        desired, measured = self.desired(observed), self.measured(observed)
        force, tare = self._taring.step(state[3:], observed["contact_force"], measured.pose[..., :3])
        h_A = np.concatenate([force, np.zeros(force.shape)], axis=-1)
        z = Displacement(*state[1:3])
        K_P, K_D = self.settings.proportional_gain, self.settings.derivative_gain
        error = desired.pose - z.value - measured.pose
        acceleration = (
            desired.acceleration
            - self.compliant_frame.acceleration(z, h_A)
            + K_D * (desired.velocity - z.rate - measured.velocity)
            + K_P * error
        )
        acceleration, integral = self._integral.step(acceleration, error, state[:1])
        torque = self.resolved_torque(measured, acceleration, self.settings.pseudoinverse_damping)
        after = self.compliant_frame.advance(z, h_A, h_A)
        return torque + self.contact_torque(measured, force), (*integral, *after, *tare)


register_controller(
    ControllerSpec(
        name="admittance",
        summary="admittance: a compliant frame driven by the contact force, tracked by inverse dynamics",
        policy=AdmittanceController,
        data=ControllerData.beside(__file__, target_impedance_sets=("tuned", "tuned_50hz")),
        command_inputs=("pose_offset",),
        chapter=13,
    )
)
