"""The stiffness of a surface, estimated online from the force and the position of the tip in contact."""

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from prp_gym.errors import InvalidValueError
from prp_gym.robot.arrays import Array

_WEIGHT, _POSITION, _FORCE, _POSITION_SPREAD, _COVARIATION = range(5)


@dataclass(frozen=True)
class StiffnessEstimator:
    """Recursive least squares of f = K p + c over one contact, with an initial guess and with forgetting.

    With weights w_i, means p̄ and f̄, S_pp = Σ w_i (p_i - p̄)² and S_pf = Σ w_i (p_i - p̄)(f_i - f̄):
    K̂ = (S_pf + s K_0)/(S_pp + s), limited to `allowed`. So the guess K_0 counts as much as a spread s of
    positions, and a constant bias of the force sensor is part of c and leaves K̂ alone. The weights fade with
    a time constant, but only in periods that bring at least as much spread as fading takes: a tip at rest
    neither changes the estimate nor makes it forget.

    Attributes:
        initial_stiffness: initial guess K_0, above 0 [N/m].
        forgetting_time: time constant of the weights, above 0 [s].
        period: time between two measurements [s].
        allowed: least and largest K̂ [N/m].
        guess_spread: weight s of the guess [m^2], for force noise of 0.05 N and a guess within 5000 N/m.

    Raises:
        InvalidValueError: a stiffness or a time that is not positive.

    Source: [S] 8.5.4, for the estimation of parameters online.
    """

    initial_stiffness: float
    forgetting_time: float
    period: float

    allowed: ClassVar[tuple[float, float]] = (10.0, 2e4)
    guess_spread: ClassVar[float] = (0.05 / 5000.0) ** 2

    def __post_init__(self) -> None:
        for name, unit in (("initial_stiffness", "N/m"), ("forgetting_time", "s"), ("period", "s")):
            if not getattr(self, name) > 0.0:
                raise InvalidValueError(name, getattr(self, name), "above 0", unit)

    @property
    def retention(self) -> float:
        """Factor by which a weight decays in one period."""
        return math.exp(-self.period / self.forgetting_time)

    def begin(self, shape: tuple[int, ...]) -> Array:
        """An empty memory (*shape, 5), without a measurement."""
        return np.zeros((*shape, 5))

    def update(self, memory: Array, position: Array, force: Array, contact: NDArray[np.bool_]) -> Array:
        """The memory with one more measurement, or empty where there is no contact.

        Args:
            memory: weighted moments (..., 5) of the measurements so far.
            position: tip position p (...) along the force axis [m].
            force: force f (...) by the tip on the surface along that axis [N].
            contact: (...) whether the tip touches the surface.

        Returns:
            (..., 5).
        """
        kept = self._with(memory, position, force, 1.0)
        faded = self._with(memory, position, force, self.retention)
        richer = faded[..., _POSITION_SPREAD] >= memory[..., _POSITION_SPREAD]
        after = np.where(richer[..., None], faded, kept)
        return np.where(contact[..., None], after, 0.0)

    def stiffness(self, memory: Array) -> Array:
        """K̂ (...) [N/m]."""
        s = self.guess_spread
        learned = memory[..., _COVARIATION] + s * self.initial_stiffness
        estimate: Array = learned / (memory[..., _POSITION_SPREAD] + s)
        return np.clip(estimate, *self.allowed)

    @staticmethod
    def _with(memory: Array, position: Array, force: Array, retention: float) -> Array:
        """The weighted moments with one more measurement, all earlier weights times `retention`."""
        before = retention * memory[..., _WEIGHT]
        weight = before + 1.0
        step, force_step = position - memory[..., _POSITION], force - memory[..., _FORCE]
        spread = before / weight * step
        return np.stack(
            [
                weight,
                memory[..., _POSITION] + step / weight,
                memory[..., _FORCE] + force_step / weight,
                retention * memory[..., _POSITION_SPREAD] + spread * step,
                retention * memory[..., _COVARIATION] + spread * force_step,
            ],
            axis=-1,
        )
