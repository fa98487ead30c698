"""The stiffness and damping of a surface, estimated online from force and motion of the tip in contact."""

import math
from dataclasses import dataclass, field
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from prp_gym.errors import InvalidValueError
from prp_gym.robot.arrays import Array

_WEIGHT, _POSITION, _RATE, _FORCE = range(4)  # sum of the weights, and weighted means
_PP, _PR, _RR, _PF, _RF = range(4, 9)  # weighted sums of products of deviations from the means
_SIZE = 9


class EstimatedSurface(NamedTuple):
    """The estimated surface.

    Attributes:
        stiffness: K̂ (...) [N/m].
        damping: D̂ (...), at least 0 [N s/m].
        deviation: standard deviation σ_K (...) of K̂ at a given D̂, above 0 [N/m].
        upper_stiffness: K̂ + 8 σ_K (...), but no more than a surface can have, nor less than K̂ [N/m].
    """

    stiffness: Array
    damping: Array
    deviation: Array
    upper_stiffness: Array


@dataclass(frozen=True)
class StiffnessEstimator:
    """Recursive least squares of f = K p + D ṗ + c, with an initial guess and with forgetting.

    With weights w_i, means p̄, ṗ̄ and f̄, and the sums S_pp = Σ w_i (p_i - p̄)², S_pr, S_rr, S_pf, S_rf of
    products of deviations (r: ṗ), K̂ and D̂ minimise the squared residuals plus s_p (K - K_0)² + s_r D²:
    (S_pp + s_p) K + S_pr D = S_pf + s_p K_0, S_pr K + (S_rr + s_r) D = S_rf; D̂ is limited to `dampings`, K̂
    follows from it and is limited to `allowed`. So the guess K_0 counts as much as a spread s_p of positions,
    and a constant bias of the force sensor is part of c and leaves K̂ alone. The weights fade with a time
    constant, but only in periods that bring at least as much spread as fading takes: a tip at rest neither
    changes the estimate nor makes it forget. With force noise σ_f the standard deviation of K̂ at a given D̂ is
    σ_K = σ_f/√(S_pp + s_p): the first samples of a touch say little, and K̂ may then be far too small.

    Attributes:
        initial_stiffness: initial guess K_0, above 0 [N/m].
        forgetting_time: time constant of the weights, above 0 [s].
        period: time between two measurements [s].
        greatest_stiffness: greatest stiffness of a surface; infinite if unknown [N/m].
        retention: factor by which a weight decays in one period.
        allowed: least and largest K̂ [N/m].
        dampings: least and largest D̂ [N s/m].
        force_noise: standard deviation σ_f of the force sensor's noise [N].
        caution: number of standard deviations to the upper bound, above the usual 2 since the braking of the
            tip and the delay of the sensor falsify the first samples of a touch as much as noise does.
        guess_spread: weight s_p of the guess [m^2], for that noise and a guess within 5000 N/m.
        damping_spread: weight s_r of no damping [m^2/s^2], for the same noise and dampings within 10 N s/m.

    Raises:
        InvalidValueError: a stiffness or a time that is not positive.

    Source: [S] 8.5.4, for the estimation of parameters online.
    """

    initial_stiffness: float
    forgetting_time: float
    period: float
    greatest_stiffness: float = math.inf
    retention: float = field(init=False)

    allowed: ClassVar[tuple[float, float]] = (1.0, 2e4)
    dampings: ClassVar[tuple[float, float]] = (0.0, 100.0)
    force_noise: ClassVar[float] = 0.05
    caution: ClassVar[float] = 8.0
    guess_spread: ClassVar[float] = (force_noise / 5000.0) ** 2
    damping_spread: ClassVar[float] = (force_noise / 10.0) ** 2

    def __post_init__(self) -> None:
        for name, unit in (("initial_stiffness", "N/m"), ("forgetting_time", "s"), ("period", "s")):
            if not getattr(self, name) > 0.0:
                raise InvalidValueError(name, getattr(self, name), "above 0", unit)
        object.__setattr__(self, "retention", math.exp(-self.period / self.forgetting_time))

    def begin(self, shape: tuple[int, ...]) -> Array:
        """An empty memory (*shape, 9), without a measurement."""
        return np.zeros((*shape, _SIZE))

    def update(
        self, memory: Array, position: Array, rate: Array, force: Array, contact: NDArray[np.bool_]
    ) -> Array:
        """The memory with one more measurement, or as it was where there is no contact.

        Args:
            memory: weighted moments (..., 9) of the measurements so far.
            position: tip position p (...) along the force axis [m].
            rate: velocity ṗ (...) of the tip along that axis [m/s].
            force: force f (...) by the tip on the surface along that axis [N].
            contact: (...) whether the tip touches the surface.

        Returns:
            (..., 9).
        """
        kept = self._with(memory, position, rate, force, 1.0)
        faded = self._with(memory, position, rate, force, self.retention)
        richer = faded[..., _PP] >= memory[..., _PP]
        after = np.where(richer[..., None], faded, kept)
        return np.where(contact[..., None], after, memory)

    def surface(self, memory: Array) -> EstimatedSurface:
        """K̂, D̂, σ_K and the upper bound on the stiffness (...)."""
        spread, cross = memory[..., _PP] + self.guess_spread, memory[..., _PR]
        learned = memory[..., _PF] + self.guess_spread * self.initial_stiffness
        rates = memory[..., _RR] + self.damping_spread
        determinant = np.maximum(spread * rates - cross * cross, self.guess_spread * self.damping_spread)
        damping = np.clip((memory[..., _RF] * spread - cross * learned) / determinant, *self.dampings)
        stiffness = np.clip((learned - cross * damping) / spread, *self.allowed)
        deviation = self.force_noise / np.sqrt(spread)
        upper = np.minimum(stiffness + self.caution * deviation, self.greatest_stiffness)
        return EstimatedSurface(stiffness, damping, deviation, np.maximum(stiffness, upper))

    def stiffness(self, memory: Array) -> Array:
        """K̂ (...) [N/m]."""
        return self.surface(memory).stiffness

    @staticmethod
    def _with(memory: Array, position: Array, rate: Array, force: Array, retention: float) -> Array:
        """The weighted moments with one more measurement, all earlier weights times `retention`."""
        before = retention * memory[..., _WEIGHT]
        weight = before + 1.0
        step = position - memory[..., _POSITION]
        rate_step, force_step = rate - memory[..., _RATE], force - memory[..., _FORCE]
        spread, rate_spread = before / weight * step, before / weight * rate_step
        return np.stack(
            [
                weight,
                memory[..., _POSITION] + step / weight,
                memory[..., _RATE] + rate_step / weight,
                memory[..., _FORCE] + force_step / weight,
                retention * memory[..., _PP] + spread * step,
                retention * memory[..., _PR] + spread * rate_step,
                retention * memory[..., _RR] + rate_spread * rate_step,
                retention * memory[..., _PF] + spread * force_step,
                retention * memory[..., _RF] + rate_spread * force_step,
            ],
            axis=-1,
        )
