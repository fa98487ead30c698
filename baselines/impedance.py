"""Impedance control: the end effector behaves as a chosen mass, damper and spring under the contact force."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from prp_gym.baselines.base.control_interface import ControlInterface
from prp_gym.baselines.base.force_sensing import ForceSensingSettings
from prp_gym.baselines.base.operational import MEASURED_MOTION, ArmState, OperationalBaseline
from prp_gym.baselines.base.policy import ControllerState, Observed
from prp_gym.baselines.base.settings import Vector
from prp_gym.baselines.base.spec import ControllerData, ControllerSpec, register_controller
from prp_gym.robot.arrays import Array


@dataclass(frozen=True, eq=False)
class ImpedanceSettings(ForceSensingSettings):
    """Settings of `ImpedanceController`, along the axes of the world and of the Euler angles.

    Attributes:
        inertia: M_d (6), diagonal, above 0 [kg, ..., kg m^2, ...].
        damping: K_D (6), diagonal [N s/m, ..., N m s/rad, ...].
        stiffness: K_P (6), diagonal [N/m, ..., N m/rad, ...].
    """

    inertia: Any
    damping: Any
    stiffness: Any

    vectors: ClassVar = {
        "inertia": Vector("pose", "kg (3), kg·m² (3)", above_zero=True),
        "damping": Vector("pose", "N·s/m (3), N·m·s/rad (3)"),
        "stiffness": Vector("pose", "N/m (3), N·m/rad (3)"),
    }


class ImpedanceController(OperationalBaseline[ImpedanceSettings]):
    """τ = B y + n + J_Aᵀh_A, y = J_A⁺M_d⁻¹(M_d ẍ_d + K_D (ẋ_d - ẋ) + K_P x̃ - M_d J̇_A q̇ - h_A), x̃ = x_d - x.

    n = C q̇ + F_v q̇ + F_s sign(q̇) + g; h_A = (h_e, 0) is the measured force by the tip on the surface. With
    the exact model the closed loop is J_Aᵀ(x̃¨ + M_d⁻¹(K_D x̃˙ + K_P x̃ - h_A)) = 0: along an axis that the
    arm can move on its own it behaves as M_d x̃¨ + K_D x̃˙ + K_P x̃ = h_A; elsewhere, as near to it as three
    joints come, accelerations weighted equally. There a surface of stiffness K at a depth d before the
    reference is pressed with K K_P/(K + K_P) d.

    In continuous time the model M_d, K_D, K_P is stable for any positive numbers, and passive: no passive
    surface makes it unstable. Held over a period dt, K_D dt < 2 M_d and K_P dt < 2 K_D are needed on every
    axis; in contact with a stiffness K the force acts half a period late through the controller but at once
    on the arm, which reduces the damping K_D/M_d by about K dt (1/M_d - 1/m)/2, with the mass m of the arm
    along the normal (1.5 kg, down to 0.26 kg): with a small M_d the tip oscillates on a stiff surface.

    Action modes may scale K_P by `stiffness_factor` along x, y, z, α and β, with K_D so that every
    axis keeps its damping ratio, and that ratio by `damping_factor`.

    Source: [S] 9.2.2; [R] 12, with M_d ẍ_d.
    """

    measured_fields = (*MEASURED_MOTION, "contact_force")
    settings_class = ImpedanceSettings
    rendered = ("inertia", "damping", "stiffness")

    def __init__(self, interface: ControlInterface, settings: ImpedanceSettings) -> None:
        super().__init__(interface, settings)
        self._taring = self.settings.make_taring(interface.period)

    def initial_state(self, observed: Observed) -> ControllerState:
        """The memory of the taring; see `Baseline.initial_state`."""
        return self._taring.begin(observed["joint_position"].shape[:-1])

    def control(self, observed: Observed, state: ControllerState) -> tuple[Array, ControllerState]:
        """See `Baseline.control`."""
        measured = self.measured(observed)
        force, tare = self._taring.step(state, observed["contact_force"], measured.pose[..., :3])
        return self._torque(observed, measured, force), tare

    def _torque(self, observed: Observed, state: ArmState, force: Array) -> Array:
        """See the class; h_e is the tared force (..., 3) [N]."""
        desired = self.desired(observed)
        stiffness = self.settings.stiffness * _factor(observed, "stiffness_factor")
        damping = self.settings.damping * np.sqrt(_factor(observed, "stiffness_factor"))
        damping = damping * _factor(observed, "damping_factor")
        pull = damping * (desired.velocity - state.velocity)
        pull = pull + stiffness * (desired.pose - state.pose)
        pull[..., :3] -= force
        acceleration = desired.acceleration + pull / self.settings.inertia
        return self.resolved_torque(state, acceleration) + self.contact_torque(state, force)


def _factor(observed: Observed, name: str) -> Array:
    """A factor of all six axes (..., 6): the observed one, and 1 for γ; 1 throughout where there is none."""
    if name not in observed:
        return np.ones(6)
    factor = observed[name]
    return np.concatenate([factor, np.ones((*factor.shape[:-1], 1))], axis=-1)


register_controller(
    ControllerSpec(
        name="impedance",
        summary="impedance control: mass, damper and spring, with force measurement",
        policy=ImpedanceController,
        data=ControllerData.beside(__file__, target_impedance_sets=("tuned", "tuned_50hz")),
        command_inputs=("pose_offset", "stiffness_factor", "damping_factor"),
        chapter=12,
    )
)
