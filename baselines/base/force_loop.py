"""What the force controllers share: an inner position loop whose target the force error moves."""

from abc import abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar, TypeVar

import numpy as np
from numpy.typing import NDArray

from prp_gym.baselines.base.approach_speed import ApproachSpeed, FixedSpeed, SpeedForForce, braking_time
from prp_gym.baselines.base.control_interface import ControlInterface
from prp_gym.baselines.base.force_integral import (
    STEADY,
    FixedGains,
    ForceError,
    ForceIntegral,
    RateScaling,
    ScheduledGain,
    TipMotion,
)
from prp_gym.baselines.base.force_sensing import ForceSensingSettings
from prp_gym.baselines.base.operational import MEASURED_MOTION, OperationalBaseline
from prp_gym.baselines.base.policy import ControllerState, Observed
from prp_gym.baselines.base.references import PoseReference
from prp_gym.baselines.base.settings import Vector
from prp_gym.baselines.base.stiffness_estimator import StiffnessEstimator
from prp_gym.robot.arrays import Array, zeros

FORCE_COMMAND_INPUTS = ("force_offset", "approach_speed_factor", "bandwidth_factor")
"""The inputs of every force controller that action modes may drive."""


@dataclass(frozen=True, eq=False, kw_only=True)
class ForceLoopSettings(ForceSensingSettings):
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
        approach: `fixed` approaches at `approach_speed`, `from_force` as fast as the desired force allows on
            the stiffest surface that the task declares.
        approach_speed: largest speed v_max of the estimated form's position target [m/s].
        least_approach_speed: least speed v_min of an approach that follows from the force [m/s].
        approach_deceleration: a, with which the actuators can brake the tip, at least 0 [m/s^2].
        approach_factor: η, factor on the speed that follows from the force [1].
        contact_threshold: force from which the estimated form assumes contact [N].
        initial_stiffness: stiffness estimate before the first contact, above 0 [N/m]; the greatest stiffness
            that the task declares replaces it where that is less.
        forgetting_time: time constant with which the estimate forgets old measurements, above 0 [s].
    """

    inertia: Any
    derivative_gain: Any
    proportional_gain: Any
    force_gain: float
    integral_gain: float
    stiffness: str = "fixed"
    bandwidth: float = 10.0
    approach: str = "fixed"
    approach_speed: float = 0.03
    least_approach_speed: float = 0.0
    approach_deceleration: float = 20.0
    approach_factor: float = 1.0
    contact_threshold: float = 0.4
    initial_stiffness: float = 5000.0
    forgetting_time: float = 0.5

    vectors: ClassVar = {
        "inertia": Vector("pose", "kg, kg·m²", above_zero=True),
        "derivative_gain": Vector("pose", "N·s/m, N·m·s/rad"),
        "proportional_gain": Vector("pose", "N/m, N·m/rad"),
    }
    numbers: ClassVar = {
        **ForceSensingSettings.numbers,
        "force_gain": "m/N",
        "integral_gain": "m/(N·s)",
        "bandwidth": "rad/s",
        "approach_speed": "m/s",
        "least_approach_speed": "m/s",
        "approach_deceleration": "m/s²",
        "approach_factor": "1",
        "contact_threshold": "N",
        "initial_stiffness": "N/m",
        "forgetting_time": "s",
    }
    choices: ClassVar = {
        **ForceSensingSettings.choices,
        "stiffness": ("fixed", "estimated"),
        "approach": ("fixed", "from_force"),
    }

    def force_integral(self, period: float, greatest_stiffness: float) -> ForceIntegral:
        """The outer loop.

        Args:
            period: control period [s].
            greatest_stiffness: greatest stiffness of a surface; infinite if unknown [N/m].
        """
        if self.stiffness == "fixed":
            return FixedGains(self.force_gain, self.integral_gain, period)
        guess = min(self.initial_stiffness, greatest_stiffness)
        estimator = StiffnessEstimator(guess, self.forgetting_time, period, greatest_stiffness)
        speed = self._speed(period, greatest_stiffness)
        return ScheduledGain(self.bandwidth, speed, self.contact_threshold, estimator)

    def _speed(self, period: float, greatest_stiffness: float) -> ApproachSpeed:
        """The speed of the target; the inner loop's slowest axis of translation limits it."""
        if self.approach == "fixed":
            return FixedSpeed(self.approach_speed, self.approach_speed)
        largest = self.approach_speed
        least = min(self.least_approach_speed, largest)
        gain, inertia = self.proportional_gain[:3], self.inertia[:3]
        delay = max(braking_time(period, *axis) for axis in zip(gain, inertia, strict=True))
        stop = self.approach_deceleration
        return SpeedForForce(greatest_stiffness, delay, stop, least, largest, self.approach_factor)


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
        self._integral = self.settings.force_integral(interface.period, interface.greatest_stiffness)
        self._taring = self.settings.make_taring(interface.period)

    def initial_state(self, observed: Observed) -> ControllerState:
        """A displacement of zero, no estimate and no tare yet; see `Baseline.initial_state`."""
        shape = observed["joint_position"].shape[:-1]
        return *self._integral.begin(shape), *self._taring.begin(shape)

    @abstractmethod
    def base_motion(self, observed: Observed, state: ControllerState, error: ForceError) -> PoseReference:
        """The motion (x_r, ẋ_r, ẍ_r) of the target without displacement.

        Args:
            observed: fields by name, each (..., size).
            state: state of the controller; the force loop's arrays come first, then those of the subclass.
            error: force error.
        """

    def _hold(
        self, before: ControllerState, after: ControllerState, limited: NDArray[np.bool_]
    ) -> ControllerState:
        """Hold the displacement, and restart what follows the force error; see `Baseline._hold`."""
        held = super()._hold(before, after, limited)
        return tuple(
            np.where(limited[..., None], 0.0, new) if index in self._integral.restarted else new
            for index, new in enumerate(held)
        )

    def control(self, observed: Observed, state: ControllerState) -> tuple[Array, ControllerState]:
        """See `Baseline.control`."""
        measured, count = self.measured(observed), self._integral.arrays
        tared = count + self._taring.arrays
        force, tare = self._taring.step(state[count:tared], observed["contact_force"], measured.pose[..., :3])
        desired = observed.get("desired_force", np.zeros(force.shape)) + observed.get("force_offset", 0.0)
        error = ForceError.of(desired, force)
        base = self.base_motion(observed, state, error)
        M_d, K_D, K_P = self.settings.inertia, self.settings.derivative_gain, self.settings.proportional_gain
        braking = K_D * (base.velocity - measured.velocity)
        lag = np.divide(-braking, K_P, out=zeros(braking.shape, braking), where=K_P > 0.0)
        tip = TipMotion(measured.pose[..., :3], measured.velocity[..., :3], lag[..., :3])
        x_F, memory = self._integral.step(state[:count], error, tip, _rate_scaling(observed))
        position_error = base.pose - measured.pose
        position_error[..., :3] += x_F
        effort = braking + K_P * position_error
        torque = self.resolved_torque(measured, base.acceleration + effort / M_d)
        return torque + self.contact_torque(measured, force), (*memory, *tare, *state[tared:])


def _rate_scaling(observed: Observed) -> RateScaling:
    """The observed factors; 1 where there are none."""
    return RateScaling(
        observed.get("approach_speed_factor", STEADY.approach),
        observed.get("bandwidth_factor", STEADY.bandwidth),
    )
