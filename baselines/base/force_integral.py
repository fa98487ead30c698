"""How far a force error moves the position target: by fixed gains, or by gains after an online estimate."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np

from prp_gym.baselines.base.approach_speed import ApproachSpeed
from prp_gym.baselines.base.stiffness_estimator import EstimatedSurface, StiffnessEstimator
from prp_gym.robot.arrays import Array, dot, norm, zeros

Memory = tuple[Array, ...]

_LOST, _NEVER, _TOUCHING = -1.0, 0.0, 1.0  # phases of contact


class ForceError(NamedTuple):
    """The desired and the measured contact force along one axis.

    Attributes:
        axis: n (..., 3), a unit vector into the surface, world frame; zero where no force defines one.
        desired: desired force n·f_d (..., 1), at least 0 [N].
        measured: measured force n·f_e (..., 1) by the tip on the surface [N].
    """

    axis: Array
    desired: Array
    measured: Array

    @property
    def value(self) -> Array:
        """The force error e = n·f_d - n·f_e (..., 1) [N]."""
        return self.desired - self.measured

    def along(self, vector: Array) -> Array:
        """The component (..., 1) of a vector (..., 3) along the axis."""
        return dot(self.axis, vector)[..., None]

    @classmethod
    def of(cls, desired: Array, measured: Array) -> "ForceError":
        """The force error along the desired force, or along the measured force where none is desired.

        Args:
            desired: f_d (..., 3) by the tip on the surface, world frame [N].
            measured: f_e (..., 3), likewise [N].
        """
        size = norm(desired)[..., None]
        along = np.where(size > 0.0, desired, measured)
        length = norm(along)[..., None]
        axis = np.divide(along, length, out=zeros(along.shape, along), where=length > 0.0)
        return cls(axis, size, dot(axis, measured)[..., None])


class TipMotion(NamedTuple):
    """The measured motion of the tip, world frame.

    Attributes:
        position: position of the tip (..., 3) [m].
        velocity: velocity of the tip (..., 3) [m/s].
        lag: distance (..., 3) by which the moving tip stays behind its target [m].
    """

    position: Array
    velocity: Array
    lag: Array


class RateScaling(NamedTuple):
    """Factors on the rates of a force loop, which an action mode may drive.

    Attributes:
        approach: factor (..., 1) by which the approach speed is scaled before contact.
        bandwidth: factor (..., 1) by which the bandwidth is scaled in contact.
    """

    approach: Array
    bandwidth: Array


STEADY = RateScaling(np.ones(1), np.ones(1))
"""Factors of 1, which leave the rates as the settings give them."""


class ForceIntegral(ABC):
    """The displacement x_F by which a force error moves the target of a position loop.

    Its memory is a tuple of arrays (..., any size); the first is held while an actuator is at its limit.

    Attributes:
        arrays: number of state arrays.
        restarted: indices of the state arrays that are set to 0 while an actuator is at its limit.
    """

    arrays: ClassVar[int]
    restarted: ClassVar[tuple[int, ...]] = ()

    @abstractmethod
    def begin(self, shape: tuple[int, ...]) -> Memory:
        """The memory at the start of an episode, for leading dimensions `shape`."""

    @abstractmethod
    def step(
        self, memory: Memory, error: ForceError, tip: TipMotion, rate_scaling: RateScaling = STEADY
    ) -> tuple[Array, Memory]:
        """One control period.

        Args:
            memory: state arrays from `begin` or from the last call.
            error: force error.
            tip: measured motion of the tip.
            rate_scaling: factors on the rates that the gains give.

        Returns:
            x_F (..., 3) [m] for this period, and the memory a period later.
        """


@dataclass(frozen=True)
class FixedGains(ForceIntegral):
    """x_F = n (K_F e + K_I ∫e dt).

    Attributes:
        force_gain: proportional force gain K_F [m/N].
        integral_gain: integral force gain K_I [m/(N s)].
        period: control period [s].
    """

    force_gain: float
    integral_gain: float
    period: float

    arrays: ClassVar[int] = 1

    def begin(self, shape: tuple[int, ...]) -> Memory:
        """A displacement of zero."""
        return (np.zeros((*shape, 3)),)

    def step(
        self, memory: Memory, error: ForceError, tip: TipMotion, rate_scaling: RateScaling = STEADY
    ) -> tuple[Array, Memory]:
        """See `ForceIntegral.step`; the bandwidth is that of the integral, and there is no approach."""
        pull = error.axis * error.value
        (displacement,) = memory
        after = displacement + self.period * self.integral_gain * rate_scaling.bandwidth * pull
        return displacement + self.force_gain * pull, (after,)


@dataclass(frozen=True)
class ScheduledGain(ForceIntegral):
    """ẋ_F = n ω_c e_D/K̂ in contact, at most v; n v before it where a force is desired.

    e_D is the predicted error e - K̂ n·l behind a low pass with the time constant D̂/K̂, or 0.2/ω_c if that is
    more; it starts from 0 at the touch, and wherever an actuator was at its limit. l = (K_D/K_P) ẋ is the
    distance that the inner loop has yet to go when its target stops. On a surface of stiffness K and damping
    D the force error decays as exp(-ω_c K/K̂ t): after the estimates K̂ and D̂, equally fast on all surfaces.
    With K̂ = K and without the low pass the loop is M_d s³ + K_D s² + (K_P + ω_c K_D) s + ω_c K_P: by Routh it
    is stable for every ω_c if K_D² > M_d K_P, while without the prediction ω_c < K_D/M_d is needed.
    Without the low pass a damping above about 2 K/ω_c makes the loop unstable, since the damper passes the
    speed of the target on to the force at once. The limit is v(K̂ + 8 σ_K): the first samples of a touch, in
    which noise may hide the stiffness, do not make the target fast.

    When contact begins, x_F is reduced by the lag of the inner loop in the approach: the tip brakes at once,
    and the part of x_F that balances a disturbance stays. The force then peaks below
    f_t + K v (dt + 1/(e ω)), with Euler's number e, an inner loop of double pole -ω, a period dt and the
    force f_t at which contact is detected; this peak is unavoidable at the approach speed v. Where contact is
    lost, the target returns at the speed ω_c e/K̂ of contact, and at v_min at least. There is no
    proportional part, since K_F e would pass the force sensor's noise on to the torques.

    Attributes:
        bandwidth: bandwidth ω_c of the force loop in contact [rad/s].
        speed: largest speed v of the position target.
        contact_threshold: force at which contact begins; contact ends at half of it [N]. Half the desired
            force replaces it where that is less.
        estimator: estimator of the surface.
    """

    bandwidth: float
    speed: ApproachSpeed
    contact_threshold: float
    estimator: StiffnessEstimator

    arrays: ClassVar[int] = 4
    restarted: ClassVar[tuple[int, ...]] = (2,)
    least_delay: ClassVar[float] = 0.2

    def begin(self, shape: tuple[int, ...]) -> Memory:
        """A displacement of zero, no contact, no filtered error, and an estimator without measurements."""
        return (
            np.zeros((*shape, 3)),
            np.zeros((*shape, 1)),
            np.zeros((*shape, 1)),
            self.estimator.begin(shape),
        )

    def step(
        self, memory: Memory, error: ForceError, tip: TipMotion, rate_scaling: RateScaling = STEADY
    ) -> tuple[Array, Memory]:
        """See `ForceIntegral.step`."""
        displacement, phase = memory[0], memory[1]
        touching = phase == _TOUCHING
        contact = error.measured > self._threshold(error) * np.where(touching, 0.5, 1.0)
        ahead = np.maximum(error.along(tip.lag), 0.0)
        displacement = displacement - np.where(contact & ~touching, error.axis * ahead, 0.0)
        estimate = self.estimator.update(
            memory[3],
            error.along(tip.position)[..., 0],
            error.along(tip.velocity)[..., 0],
            error.measured[..., 0],
            contact[..., 0],
        )
        surface = self.estimator.surface(estimate)
        stiffness, period = surface.stiffness[..., None], self.estimator.period
        delay = np.maximum(
            surface.damping[..., None] / stiffness, self.least_delay / max(self.bandwidth, 1e-9)
        )
        predicted = error.value - stiffness * error.along(tip.lag)
        smooth = np.where(contact, memory[2] + period / (period + delay) * (predicted - memory[2]), 0.0)
        phase = np.where(contact, _TOUCHING, np.where(phase == _NEVER, _NEVER, _LOST))
        rate = self._rate(error, smooth, phase, surface, rate_scaling)
        after = displacement + period * error.axis * rate
        return displacement, (after, phase, smooth, estimate)

    def _threshold(self, error: ForceError) -> Array:
        half = np.where(error.desired > 0.0, 0.5 * error.desired, np.inf)
        return np.minimum(half, self.contact_threshold)

    def _rate(
        self,
        error: ForceError,
        smooth: Array,
        phase: Array,
        surface: EstimatedSurface,
        rate_scaling: RateScaling,
    ) -> Array:
        """ẋ_F along the axis (..., 1) [m/s]."""
        wanted = self.bandwidth * rate_scaling.bandwidth / surface.stiffness[..., None]
        stiffest = surface.upper_stiffness[..., None]
        limit = rate_scaling.approach * self.speed.in_contact(error.desired, stiffest)
        touching = np.clip(wanted * smooth, -limit, limit)
        first = rate_scaling.approach * self.speed.before_contact(error.desired, self._threshold(error))
        again = np.minimum(np.maximum(wanted * error.value, self.speed.least), first)
        free = np.where(phase == _NEVER, first, again) * (error.value > 0.0)
        return np.where(phase == _TOUCHING, touching, free)
