"""What the force controllers share: an inner position loop whose target the force error moves."""

from abc import abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar, TypeVar

import numpy as np

from prp_gym.baselines.base.force_integral import (
    STEADY,
    FixedGains,
    ForceError,
    ForceIntegral,
    RateScaling,
    ScheduledGain,
)
from prp_gym.baselines.base.operational import MEASURED_MOTION, OperationalBaseline
from prp_gym.baselines.base.policy import ControlInterface, ControllerState, Observed
from prp_gym.baselines.base.references import PoseReference
from prp_gym.baselines.base.settings import Settings, Vector
from prp_gym.baselines.base.stiffness_estimator import StiffnessEstimator
from prp_gym.robot.arrays import Array

FORCE_COMMAND_INPUTS = ("force_offset", "approach_speed_factor", "bandwidth_factor")
"""The inputs of every force controller that action modes may drive."""


@dataclass(frozen=True, eq=False, kw_only=True)
class ForceLoopSettings(Settings):
    """Settings of a force controller.

    Attributes:
        inertia: M_d (pose), diagonal, above 0 [kg, kg, kg, kg m^2, kg m^2, kg m^2].
        derivative_gain: K_D (pose), diagonal [N s/m, N s/m, N s/m, N m s/rad, N m s/rad, N m s/rad].
        proportional_gain: K_P (pose), diagonal [N/m, N/m, N/m, N m/rad, N m/rad, N m/rad].
        force_gain: K_F of the fixed form [m/N].
        integral_gain: K_I of the fixed form [m/(N s)].
        stiffness: `fixed` uses constant gains, `estimated` computes the gain from an online estimate of the
            surface stiffness.
        bandwidth: ω_c of the estimated form [rad/s].
        approach_speed: v of the estimated form, the largest speed of its position target [m/s].
        contact_threshold: force from which the estimated form assumes contact [N].
        initial_stiffness: stiffness estimate at the start of every contact, above 0 [N/m].
        forgetting_time: time constant with which the estimate forgets old measurements, above 0 [s].
    """

    inertia: Any
    derivative_gain: Any
    proportional_gain: Any
    force_gain: float
    integral_gain: float
    stiffness: str = "fixed"
    bandwidth: float = 10.0
    approach_speed: float = 0.03
    contact_threshold: float = 0.4
    initial_stiffness: float = 5000.0
    forgetting_time: float = 0.5

    vectors: ClassVar = {
        "inertia": Vector("pose", "kg, kg·m²", above_zero=True),
        "derivative_gain": Vector("pose", "N·s/m, N·m·s/rad"),
        "proportional_gain": Vector("pose", "N/m, N·m/rad"),
    }
    numbers: ClassVar = {
        "force_gain": "m/N",
        "integral_gain": "m/(N·s)",
        "bandwidth": "rad/s",
        "approach_speed": "m/s",
        "contact_threshold": "N",
        "initial_stiffness": "N/m",
        "forgetting_time": "s",
    }
    choices: ClassVar = {"stiffness": ("fixed", "estimated")}

    def force_integral(self, period: float) -> ForceIntegral:
        """The outer loop, at a control period [s]."""
        if self.stiffness == "fixed":
            return FixedGains(self.force_gain, self.integral_gain, period)
        estimator = StiffnessEstimator(self.initial_stiffness, self.forgetting_time, period)
        return ScheduledGain(self.bandwidth, self.approach_speed, self.contact_threshold, estimator)


SettingsT = TypeVar("SettingsT", bound=ForceLoopSettings)


class ForceLoop(OperationalBaseline[SettingsT]):
    """τ = B J_A⁺(a - J̇_A q̇) + n + Jᵀh_e, a = ẍ_r + M_d⁻¹(K_D (ẋ_r - ẋ) + K_P (x_r + x_F - x)).

    (x_r, ẋ_r, ẍ_r) is the motion without force error, x_F the displacement that the force error adds. The
    desired force is zero where the observation has none. x_F is held while an actuator is at its limit.
    Action modes may add a `force_offset`, and scale the approach speed and the bandwidth in contact by
    `approach_speed_factor` and `bandwidth_factor`.

    Args:
        interface: what the controller may know of the environment.
        settings: settings of the controller.
    """

    measured_fields = (*MEASURED_MOTION, "contact_force")
    integrators = (0,)

    def __init__(self, interface: ControlInterface, settings: SettingsT) -> None:
        super().__init__(interface, settings)
        self._integral = self.settings.force_integral(interface.period)

    def initial_state(self, observed: Observed) -> ControllerState:
        """A displacement of zero and no estimate yet; see `Baseline.initial_state`."""
        return self._integral.begin(observed["joint_position"].shape[:-1])

    @abstractmethod
    def base_motion(self, observed: Observed, state: ControllerState, error: ForceError) -> PoseReference:
        """The motion (x_r, ẋ_r, ẍ_r) of the target without displacement.

        Args:
            observed: fields by name, each (..., size).
            state: state of the controller; the force loop's arrays come first, then those of the subclass.
            error: force error.
        """

    def control(self, observed: Observed, state: ControllerState) -> tuple[Array, ControllerState]:
        """See `Baseline.control`."""
        measured, force = self.measured(observed), observed["contact_force"]
        desired = observed.get("desired_force", np.zeros(force.shape)) + observed.get("force_offset", 0.0)
        error = ForceError.of(desired, force)
        base = self.base_motion(observed, state, error)
        M_d, K_D, K_P = self.settings.inertia, self.settings.derivative_gain, self.settings.proportional_gain
        braking = K_D * (base.velocity - measured.velocity)
        lag = np.divide(-braking, K_P, out=np.zeros(braking.shape), where=K_P > 0.0)
        count = self._integral.arrays
        x_F, memory = self._integral.step(
            state[:count], error, measured.pose[..., :3], lag[..., :3], _rate_scaling(observed)
        )
        position_error = base.pose - measured.pose
        position_error[..., :3] += x_F
        effort = braking + K_P * position_error
        torque = self.resolved_torque(measured, base.acceleration + effort / M_d)
        return torque + self.contact_torque(measured, force), memory + state[count:]


def _rate_scaling(observed: Observed) -> RateScaling:
    """The observed factors; 1 where there are none."""
    return RateScaling(
        observed.get("approach_speed_factor", STEADY.approach),
        observed.get("bandwidth_factor", STEADY.bandwidth),
    )
