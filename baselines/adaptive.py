"""Adaptive control: the model's parameters are estimated while the joints follow their reference."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from prp_gym.baselines.base.control_interface import ControlInterface
from prp_gym.baselines.base.policy import Baseline, ControllerState, Observed
from prp_gym.baselines.base.settings import Settings, Vector
from prp_gym.baselines.base.spec import ControllerData, ControllerSpec, register_controller
from prp_gym.errors import InvalidValueError
from prp_gym.robot.arrays import Array, apply, apply_transposed


@dataclass(frozen=True, eq=False)
class AdaptiveSettings(Settings):
    """Settings of `AdaptiveController`; an estimate starts at the parameters of `model`.

    Attributes:
        reference_gain: Λ (joints), diagonal [1/s].
        damping_gain: K_D (joints), diagonal [N m s/rad, N s/m, N m s/rad].
        adaptation_gain: Γ (parameters), diagonal [a parameter's unit squared per J].
        lower_share: lower bound of an estimate, as a share of the model's parameter [1].
        upper_share: upper bound of an estimate, as a share of the model's parameter [1].
        margin: amount by which an estimate may exceed the bound of `upper_share` (parameters), so that
            friction is also identified from a model without friction [the parameters' units].
    """

    reference_gain: Any
    damping_gain: Any
    adaptation_gain: Any
    lower_share: float = 0.2
    upper_share: float = 3.0
    margin: Any = 0.0

    vectors: ClassVar = {
        "reference_gain": Vector("joint", "1/s"),
        "damping_gain": Vector("joint", "N·m·s/rad, N·s/m, N·m·s/rad"),
        "adaptation_gain": Vector("parameter", "a parameter's unit squared per J"),
        "margin": Vector("parameter", "the parameters' units"),
    }
    numbers: ClassVar = {"lower_share": "", "upper_share": ""}

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.lower_share > 1.0:
            raise InvalidValueError("lower_share", self.lower_share, "at most 1")
        if self.upper_share < 1.0:
            raise InvalidValueError("upper_share", self.upper_share, "at least 1")


class AdaptiveController(Baseline[AdaptiveSettings]):
    """τ = Y(q, q̇, q̇_r, q̈_r) Θ̂ + K_D σ, Θ̂˙ = Γ Yᵀσ, σ = q̇_r - q̇, q̇_r = q̇_d + Λ q̃, q̈_r = q̈_d + Λ q̃˙.

    q̃ = q_d - q; Y Θ = B q̈_r + C q̇_r + F_v q̇_r + F_s sign(q̇_r) + g is linear in the parameters Θ of the model,
    of the arm or of the link. The estimate Θ̂ is the state of the controller.

    In continuous time and without torque limits V = ½ σᵀBσ + ½ Θ̃ᵀΓ⁻¹Θ̃ has V̇ = -σᵀ(K_D + F_v)σ, less a
    term of Coulomb friction that is at least 0, so that q̃ vanishes whatever the parameters are; Θ̂ stays
    bounded, and converges to Θ only if the reference excites every parameter. Each estimate is kept between
    Θ_0 - (1 - `lower_share`)|Θ_0| and Θ_0 + (`upper_share` - 1)|Θ_0| + `margin` of the model's own Θ_0: such
    a projection onto a box that holds Θ cannot make V grow, and excludes masses, inertias and friction far
    from those of the model. The estimates are held while an actuator is at its limit, where σ carries no
    information about the model.

    Held over a control period dt, the velocity is fed back with K_D + B̂Λ: K_D dt/B + Λ dt must stay well
    below 2 in every joint, where B is the inertia that it feels, 0.5 kg m² for the link and down to
    0.0096 kg m² in joint 3 of the arm (at q_3 = ±π/2, where the slide yields to it). The adaptation is an
    integral action that oscillates at √(Y Γ Yᵀ/B), which must stay well below K_D/B and 1/dt.

    Source: [S] 8.5.4; Slotine 1987; for the projection Ioannou 1996, 4.4; [R] 8, with the reference's
    velocity and acceleration in place of the measured ones, and with σ in the adaptation.
    """

    measured_fields = ("joint_position", "joint_velocity")
    settings_class = AdaptiveSettings
    integrators = (0,)

    def __init__(self, interface: ControlInterface, settings: AdaptiveSettings) -> None:
        super().__init__(interface, settings)
        self._initial = self.model.parameter_vector()
        size = np.abs(self._initial)
        self._lower = self._initial - (1.0 - self.settings.lower_share) * size
        self._upper = self._initial + (self.settings.upper_share - 1.0) * size + self.settings.margin

    def initial_state(self, observed: Observed) -> ControllerState:
        """Θ̂ (..., parameters): the model's parameters."""
        lead = observed["joint_position"].shape[:-1]
        return (np.broadcast_to(self._initial, (*lead, self._initial.size)).copy(),)

    def control(self, observed: Observed, state: ControllerState) -> tuple[Array, ControllerState]:
        """See the class."""
        (estimate,) = state
        desired = self.references.joint(observed)
        q, velocity = observed["joint_position"], observed["joint_velocity"]
        gain = self.settings.reference_gain
        reference_velocity = desired.velocity + gain * (desired.position - q)
        reference_acceleration = desired.acceleration + gain * (desired.velocity - velocity)
        sliding_variable = reference_velocity - velocity
        Y = self.model.regressor(q, velocity, reference_velocity, reference_acceleration)
        torque = apply(Y, estimate) + self.settings.damping_gain * sliding_variable
        rate = self.settings.adaptation_gain * apply_transposed(Y, sliding_variable)
        after = np.clip(estimate + self.interface.period * rate, self._lower, self._upper)
        return torque, (after,)


register_controller(
    ControllerSpec(
        name="adaptive",
        summary="adaptive control: follows in joint space and estimates the model's parameters",
        policy=AdaptiveController,
        data=ControllerData.beside(__file__),
        command_inputs=("joint_offset",),
        chapter=8,
    )
)
