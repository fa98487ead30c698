"""Time-optimal regulation within the actuator limits, by a square-root velocity profile."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from prp_gym.baselines.base.policy import Baseline, ControllerState, Observed
from prp_gym.baselines.base.settings import Settings, Vector
from prp_gym.baselines.base.spec import ControllerData, ControllerSpec, register_controller
from prp_gym.robot.arrays import Array, apply

LEAST_HEADROOM = 0.05
"""Share of an actuator's limit that the motion may always use, however large the compensated forces are."""


@dataclass(frozen=True, eq=False)
class TimeOptimalSettings(Settings):
    """Settings of `TimeOptimalController`.

    Attributes:
        acceleration_share: μ (joints), acceleration limit of a joint as a share of that which its actuator
            alone gives to its inertia, above 0 [1].
        braking_share: α (joints), planned deceleration as a share of the acceleration limit, above 0; what it
            lacks to 1 is the margin for the model's errors and the coupling of the joints [1].
        position_gain: λ (joints), commanded speed per position error near the goal, above 0 [1/s].
        velocity_gain: K_V (joints) [1/s].
        speed_limit: v_max (joints), largest commanded speed, above 0 [rad/s, m/s, rad/s].
        integral_gain: K_I (joints) of the velocity error [1/s^2].
    """

    acceleration_share: Any
    braking_share: Any
    position_gain: Any
    velocity_gain: Any
    speed_limit: Any
    integral_gain: Any = 0.0

    vectors: ClassVar = {
        "acceleration_share": Vector("joint", "1", above_zero=True),
        "braking_share": Vector("joint", "1", above_zero=True),
        "position_gain": Vector("joint", "1/s", above_zero=True),
        "velocity_gain": Vector("joint", "1/s"),
        "speed_limit": Vector("joint", "rad/s, m/s, rad/s", above_zero=True),
        "integral_gain": Vector("joint", "1/s²"),
    }


class TimeOptimalController(Baseline[TimeOptimalSettings]):
    """τ = s B u + n, u = q̈_d + sat(f'(q̃) q̃˙ + K_V σ + K_I ∫σ dt, ±a), σ = q̃˙ + f(q̃), q̃ = q_d - q.

    f is the speed at which an error may be left so that braking with b = α a just ends in the goal:
    f = λ q̃ for |q̃| ≤ b/λ², f = sign(q̃) √(2b(|q̃| - b/(2λ²))) beyond, and never above v_max. f and its slope
    f' are continuous, and the deceleration f f' never exceeds b. The limits follow from the model: joint i
    may accelerate with a_i = μ_i τ_max,i/B_ii(q), and s ≤ 1 is the largest factor with which all torques are
    within their limits, so that the direction of the acceleration is kept. n = C q̇ + F_v q̇ + F_s sign(q̇) + g.

    Far from the goal each joint accelerates with a, then brakes with b: bang-bang control with the margin
    1 - α. Over a distance d from rest this takes √(2d(1/a + 1/b)), the least time of a double integrator with
    these limits, and an approach of some 1/λ. Within the limits and with the exact model σ obeys
    σ˙ + K_V σ + K_I ∫σ dt = 0 on its own, stable for any positive K_V and for K_I ≥ 0, and q̃˙ = -f(q̃) + σ,
    where q̃ f(q̃) > 0: the goal is globally asymptotically stable, and without σ it is reached without
    overshoot. Near the goal the poles are -λ and the roots of s² + K_V s + K_I. Constant errors of the model
    are removed by the integral, which is held while a limit is active. Held over a control period, the gains
    have the limits of a PID loop, which docs/theory.md gives with and without a one-step actuation delay.

    Source: Workman 1987, the proximate time-optimal servomechanism, here with inverse dynamics ([S] 8.5.2).
    """

    measured_fields = ("joint_position", "joint_velocity")
    settings_class = TimeOptimalSettings
    integrators = (0,)

    def initial_state(self, observed: Observed) -> ControllerState:
        """K_I ∫σ dt (..., joints), zero at the start of an episode."""
        return (np.zeros(observed["joint_position"].shape),)

    def control(self, observed: Observed, state: ControllerState) -> tuple[Array, ControllerState]:
        """See the class."""
        (integral,) = state
        desired = self.references.joint(observed)
        q, velocity = observed["joint_position"], observed["joint_velocity"]
        B, n = self.model.inertia_matrix(q), self.model.bias_force(q, velocity)
        limit = self._acceleration_limit(B)
        rate = desired.velocity - velocity
        speed, slope = self._profile(desired.position - q, limit)
        sliding_variable = rate + speed
        wanted = slope * rate + self.settings.velocity_gain * sliding_variable + integral
        feasible = np.minimum(np.maximum(wanted, -limit), limit)
        effort = apply(B, desired.acceleration + feasible)
        factor = self._feasible_factor(effort, n)
        change = self.interface.period * self.settings.integral_gain * sliding_variable
        free = (feasible == wanted) & (factor == 1.0)
        return factor * effort + n, (np.where(free, integral + change, integral),)

    def _acceleration_limit(self, inertia: Array) -> Array:
        """Acceleration limit a (..., joints) from the inertia matrix (..., joints, joints)."""
        own: Array = np.diagonal(inertia, axis1=-2, axis2=-1)
        limit: Array = self.settings.acceleration_share * self.interface.torque_limit / own
        return limit

    def _profile(self, error: Array, limit: Array) -> tuple[Array, Array]:
        """f(q̃) and f'(q̃), (..., joints) each, for acceleration limits a (..., joints)."""
        gain, braking = self.settings.position_gain, self.settings.braking_share * limit
        distance, zone = np.abs(error), braking / (gain * gain)
        near = distance <= zone
        root = np.sqrt(2.0 * braking * np.maximum(distance - 0.5 * zone, 0.5 * zone))  # b/λ within the zone
        speed = np.where(near, gain * distance, root)
        slope = np.where(near, gain, braking / root)
        capped = speed > self.settings.speed_limit
        speed = np.where(capped, self.settings.speed_limit, speed)
        return np.copysign(speed, error), np.where(capped, 0.0, slope)

    def _feasible_factor(self, effort: Array, bias: Array) -> Array:
        """S (..., 1): the largest factor up to 1 with |s B u + n| within the actuator limits."""
        limit = self.interface.torque_limit
        headroom = np.maximum(limit - np.copysign(bias, effort * bias), LEAST_HEADROOM * limit)
        use = np.abs(effort) / headroom
        factor: Array = 1.0 / np.maximum(use.max(axis=-1, keepdims=True), 1.0)
        return factor


register_controller(
    ControllerSpec(
        name="time_optimal",
        summary="time-optimal regulation: a square-root velocity profile within the actuator limits",
        policy=TimeOptimalController,
        data=ControllerData.beside(__file__),
        command_inputs=("joint_offset",),
    )
)
