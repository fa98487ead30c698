"""How fast a force controller moves towards a surface, and on it."""

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from prp_gym.robot.arrays import Array


class ApproachSpeed(ABC):
    """The largest speed of a force controller's position target.

    Attributes:
        least: least speed with which the target returns to a surface [m/s].
    """

    least: float

    @abstractmethod
    def before_contact(self, desired: Array, threshold: Array) -> Array:
        """The speed (..., 1) [m/s] off the surface.

        Args:
            desired: desired force (..., 1) [N].
            threshold: force (..., 1) at which contact is detected [N].
        """

    @abstractmethod
    def in_contact(self, desired: Array, stiffness: Array) -> Array:
        """The largest speed (..., 1) [m/s] on the surface.

        Args:
            desired: desired force (..., 1) [N].
            stiffness: estimated stiffness of the surface (..., 1) [N/m].
        """


@dataclass(frozen=True)
class FixedSpeed(ApproachSpeed):
    """The same speed everywhere.

    Attributes:
        speed: largest speed v [m/s].
        least: least speed with which the target returns to a surface [m/s].
    """

    speed: float
    least: float

    def before_contact(self, desired: Array, threshold: Array) -> Array:
        """See `ApproachSpeed.before_contact`."""
        return np.array([self.speed])

    def in_contact(self, desired: Array, stiffness: Array) -> Array:
        """See `ApproachSpeed.in_contact`."""
        return np.array([self.speed])


@dataclass(frozen=True)
class SpeedForForce(ApproachSpeed):
    """The largest speed without overshoot at the touch, within [v_min, v_max].

    An inner loop with a double pole -ω, whose target stops when the force passes the threshold f_t, comes to
    rest 1/(e ω) v further, with Euler's number e; the touch is seen up to a period dt late. With
    T = dt + 1/(e ω) the force then peaks at f_t + K_max v T on a surface of stiffness K_max. Actuators that
    brake with a at most need v²/(2 a), where the force peaks at f_t + K_max v²/(2 a). So
    v = min(η (f_d - f_t)/(K_max T), √(2 a (f_d - f_t)/K_max)) keeps the peak below f_d for η = 1, and further
    below on softer surfaces. In contact the stiffness that is known there takes the place of K_max, and
    0 that of f_t; η = 1.

    Attributes:
        greatest_stiffness: greatest stiffness K_max of a surface, above 0; infinite if unknown [N/m].
        delay: T, the time in which the approach goes on after the force has reached the threshold [s].
        deceleration: a, with which the tip can brake, at least 0 [m/s^2].
        least: least speed v_min [m/s].
        largest: largest speed v_max [m/s].
        factor: η [1].
    """

    greatest_stiffness: float
    delay: float
    deceleration: float
    least: float
    largest: float
    factor: float = 1.0

    def before_contact(self, desired: Array, threshold: Array) -> Array:
        """See `ApproachSpeed.before_contact`."""
        return self._speed(desired - threshold, self.greatest_stiffness, self.factor)

    def in_contact(self, desired: Array, stiffness: Array) -> Array:
        """See `ApproachSpeed.in_contact`."""
        return self._speed(desired, stiffness, 1.0)

    def _speed(self, rise: Array, stiffness: Array | float, factor: float) -> Array:
        """The speed at which the force rises by no more than `rise` (...) [N] until the tip is at rest."""
        depth = np.maximum(rise, 0.0) / stiffness
        speed = np.minimum(factor * depth / self.delay, np.sqrt(2.0 * self.deceleration * depth))
        return np.clip(speed, self.least, self.largest)


def braking_time(period: float, stiffness: float, inertia: float) -> float:
    """T = dt + 1/(e ω) [s], ω = √(K_P/M_d): in which a critically damped inner loop comes to rest.

    Args:
        period: control period dt [s].
        stiffness: K_P of the inner loop [N/m]; without any it never comes to rest.
        inertia: M_d of the inner loop, above 0 [kg].
    """
    if stiffness == 0.0:
        return math.inf
    return period + math.sqrt(inertia / stiffness) / math.e
