"""The target of a force loop that estimates the surface that it presses."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tests.reproduction.independent.arm import Array
from tests.reproduction.independent.contact import Tip
from tests.reproduction.independent.free_space import PERIOD

_GUESS_WEIGHT = (0.05 / 5000.0) ** 2  # [m^2]
_DAMPING_WEIGHT = (0.05 / 10.0) ** 2  # [m^2/s^2]


class Fit(NamedTuple):
    """A fitted surface.

    Attributes:
        stiffness: K [N/m].
        damping: D [N s/m].
        bound: K and eight standard deviations, as far as the stiffest surface [N/m].
    """

    stiffness: float
    damping: float
    bound: float


class FittedSurface:
    """Weighted least squares of f = K p + D ṗ + c over all samples in contact, each time from all of them.

    Args:
        guess: stiffness before any sample [N/m].
        forgetting_time: time constant of the samples' weights [s].
        stiffest: stiffness of the stiffest surface that is expected [N/m].
    """

    def __init__(self, guess: float, forgetting_time: float, stiffest: float) -> None:
        self._stiffest = stiffest
        self._guess, self._fading = guess, math.exp(-PERIOD / forgetting_time)
        self._weights, self._samples = np.zeros(0), np.zeros((0, 3))
        self._spread = 0.0

    def add(self, position: float, rate: float, force: float) -> None:
        """One more sample; the older ones fade if the positions are spread at least as widely after it."""
        self._samples = np.vstack([self._samples, [position, rate, force]])
        faded = np.append(self._fading * self._weights, 1.0)
        kept = np.append(self._weights, 1.0)
        self._weights = faded if self._spread_with(faded) >= self._spread else kept
        self._spread = self._spread_with(self._weights)

    def fit(self) -> Fit:
        """The fit with D at least 0 and at most 100, K between 1 and 20,000."""
        roots = np.sqrt(self._weights)[:, None]
        deviations = roots * self._deviations(self._weights)
        priors = np.diag(np.sqrt([_GUESS_WEIGHT, _DAMPING_WEIGHT]))
        columns = np.vstack([deviations[:, :2], priors])
        forces = np.concatenate([deviations[:, 2], [priors[0, 0] * self._guess, 0.0]])
        damping = float(np.linalg.lstsq(columns, forces)[0][1])
        damping = min(max(damping, 0.0), 100.0)
        remaining = forces - columns[:, 1] * damping
        information = float(columns[:, 0] @ columns[:, 0])
        stiffness = min(max(float(columns[:, 0] @ remaining) / information, 1.0), 2e4)
        bound = min(stiffness + 8.0 * 0.05 / math.sqrt(information), self._stiffest)
        return Fit(stiffness, damping, max(stiffness, bound))

    def _spread_with(self, weights: Array) -> float:
        return float(weights @ self._deviations(weights)[:, 0] ** 2)

    def _deviations(self, weights: Array) -> Array:
        """Samples less their weighted means."""
        if not weights.size:
            return self._samples
        return np.asarray(self._samples - weights @ self._samples / weights.sum())


@dataclass(frozen=True)
class Speeds:
    """How fast the target may move; both limits are equal for one speed everywhere.

    Attributes:
        least: least speed of an approach [m/s].
        largest: largest speed [m/s].
        stiffest: stiffness of the stiffest surface that is expected [N/m].
        stop: time in which the tip comes to rest after the touch [s].
        factor: factor on the speed of the approach.
        braking: acceleration with which the tip can be stopped [m/s^2].
    """

    least: float
    largest: float
    stiffest: float = 1.0
    stop: float = 1.0
    factor: float = 1.0
    braking: float = 20.0

    def approach(self, desired: float, threshold: float) -> float:
        """So slow that the force does not exceed the desired one (for a factor of 1) [m/s]."""
        depth = (desired - threshold) / self.stiffest
        return self._within(min(self.factor * depth / self.stop, math.sqrt(2.0 * self.braking * depth)))

    def contact(self, desired: float, stiffness: float) -> float:
        """Limit on a surface [m/s]."""
        depth = desired / stiffness
        return self._within(min(depth / self.stop, math.sqrt(2.0 * self.braking * depth)))

    def _within(self, speed: float) -> float:
        return min(max(speed, self.least), self.largest)


class EstimatedPursuit:
    """A target that moves at ω e/K once in contact, with estimates of K and D.

    e is the force error when the tip has caught up with the target, behind a low pass of D/K.

    Args:
        bandwidth: ω [rad/s].
        threshold: force at which contact begins [N].
        speeds: limits of its speed.
        surface: estimate of the surface.
    """

    def __init__(self, bandwidth: float, threshold: float, speeds: Speeds, surface: FittedSurface) -> None:
        self._bandwidth, self._threshold = bandwidth, threshold
        self._speeds, self._surface = speeds, surface
        self._sum, self._smooth = 0.0, 0.0
        self._touching, self._touched = False, False

    def move(self, desired: float, force: float, tip: Tip) -> float:
        """See `Pursuit.move`."""
        threshold = min(0.5 * desired, self._threshold)
        contact = force > (0.5 * threshold if self._touching else threshold)
        if contact and not self._touching:
            self._sum -= max(tip.lag, 0.0)
        self._touching = contact
        self._touched = self._touched or contact
        displacement, error = self._sum, desired - force
        if contact:
            self._surface.add(tip.position, tip.rate, force)
            rate = self._pressing(desired, error, tip.lag)
        else:
            self._smooth = 0.0
            rate = self._free(desired, threshold, error)
        self._sum += PERIOD * rate
        return displacement

    def _pressing(self, desired: float, error: float, lag: float) -> float:
        """Speed of the target in contact [m/s]; the low pass is integrated implicitly."""
        stiffness, damping, bound = self._surface.fit()
        delay = max(damping / stiffness, 0.2 / self._bandwidth)
        left = error - stiffness * lag
        self._smooth = (delay * self._smooth + PERIOD * left) / (delay + PERIOD)
        limit = self._speeds.contact(desired, bound)
        return min(max(self._bandwidth * self._smooth / stiffness, -limit), limit)

    def _free(self, desired: float, threshold: float, error: float) -> float:
        """Speed of the target off the surface [m/s]; after a loss of contact that of contact."""
        if error <= 0.0:
            return 0.0
        first = self._speeds.approach(desired, threshold)
        if not self._touched:
            return first
        back = self._bandwidth * error / self._surface.fit().stiffness
        return min(max(back, self._speeds.least), first)
