"""Second-order models of a pose: M z̈ + K_D ż + K_P z = h, integrated exactly over control periods."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from prp_gym.checks import within
from prp_gym.errors import InvalidValueError
from prp_gym.robot.arrays import Array, as_vectors, multiply, total, zeros

_SAFE_SQUARINGS = 4  # beyond those that bring the norm to 1
_TAYLOR_TERMS = 16
_LEAST = 1e-30  # damping and stiffness above 0
_PERIODS = (1e-6, 1e6)  # [s]


class Displacement(NamedTuple):
    """The displacement of a model from its equilibrium without force.

    Attributes:
        value: Displacement z (..., 6) [m, m, m, rad, rad, rad].
        rate: Time derivative ż (..., 6) per second.
    """

    value: Array
    rate: Array

    @classmethod
    def zero(cls, shape: tuple[int, ...]) -> "Displacement":
        """A displacement of zero, at rest, with leading dimensions `shape`."""
        return cls(np.zeros((*shape, 6)), np.zeros((*shape, 6)))


@dataclass(frozen=True, eq=False)
class TargetModel:
    """Six independent axes with inertia, damping and stiffness.

    Attributes:
        inertia: Inertia M (6), above 0 [kg, kg, kg, kg m^2, kg m^2, kg m^2].
        damping: Damping K_D (6), at least 0 [N s/m, ..., N m s/rad, ...].
        stiffness: Stiffness K_P (6), at least 0 [N/m, ..., N m/rad, ...].
        period: Time between two calls of `advance` [s].

    Raises:
        ShapeError: a number of components other than six.
        InvalidValueError: an inertia or a period that is not positive, negative damping or stiffness, numbers
            whose motion is not finite.

    Source: [S] 9.3.1; [R] 12, 13.
    """

    inertia: Array
    damping: Array
    stiffness: Array
    period: float

    def __post_init__(self) -> None:
        for name in ("inertia", "damping", "stiffness"):
            object.__setattr__(self, name, as_vectors(getattr(self, name), f"target {name}", 6))
        if not (self.inertia > 0.0).all():
            raise InvalidValueError("target inertia", self.inertia.tolist(), "above 0", "kg, kg·m²")
        for name in ("damping", "stiffness"):
            values = getattr(self, name)
            if ((values != 0.0) & (values < _LEAST)).any():
                raise InvalidValueError(f"target {name}", values.tolist(), f"0, or at least {_LEAST:g}")
        object.__setattr__(self, "period", within("period", self.period, _PERIODS, "s"))
        with np.errstate(over="ignore", invalid="ignore"):
            transition = self._discretise()
        if not np.isfinite(transition).all():
            axes = (self.inertia.tolist(), self.damping.tolist(), self.stiffness.tolist())
            raise InvalidValueError("target model", axes, "numbers whose motion over a period is finite")
        object.__setattr__(self, "_transition", {3: transition[:, :, None]})

    def acceleration(self, displacement: Displacement, force: ArrayLike) -> Array:
        """The acceleration z̈ (..., 6) under a force h (..., 6) [N, N, N, N m, N m, N m]."""
        resistance = self.damping * displacement.rate + self.stiffness * displacement.value
        acceleration: Array = (as_vectors(force, "force", 6) - resistance) / self.inertia
        return acceleration

    def static_displacement(self, force: ArrayLike) -> Array:
        """The displacement K_P⁻¹ h (..., 6) at static equilibrium; 0 on axes without stiffness.

        Args:
            force: Force h (..., 6) [N, N, N, N m, N m, N m].
        """
        h = as_vectors(force, "force", 6)
        displacement: Array = np.divide(h, self.stiffness, out=zeros(h.shape, h), where=self.stiffness > 0.0)
        return displacement

    def advance(self, displacement: Displacement, start_force: Array, end_force: Array) -> Displacement:
        """Integrate over one period, in which the force varies linearly between its values at start and end.

        Args:
            displacement: Displacement at the start of the period.
            start_force: Force at the start of the period (..., 6) [N, N, N, N m, N m, N m].
            end_force: Force at the end of the period (..., 6); equal to `start_force` for a constant force.
        """
        motion = zeros((4, *displacement.value.shape), start_force)
        for index, part in enumerate((*displacement, start_force, end_force)):
            motion[index] = part
        self.follow(motion)
        return Displacement(motion[0], motion[1])

    def follow(self, motion: Array) -> None:
        """Integrate over one period in place; `advance` without a copy.

        Args:
            motion: Displacement, its rate, and the force at the start and at the end of the period
                (4, ..., 6); the first two are replaced by those at the end.
        """
        transition = vars(self)["_transition"].get(motion.ndim)
        if transition is None:
            transition = self._expand(motion.ndim)
        # over the first axis, NumPy sums in order
        np.add.reduce(transition * motion[:, None], axis=0, out=motion[:2])

    def _expand(self, dimensions: int) -> Array:
        """The transition (4, 2, ..., 6) for motions of so many dimensions, made once for each."""
        known: dict[int, Array] = vars(self)["_transition"]
        known[dimensions] = known[3].reshape(4, 2, *(1,) * (dimensions - 2), 6)
        return known[dimensions]

    def _discretise(self) -> Array:
        """The map (4, 2, 6) of (z, ż, force at the start, force at the end) to (z, ż) at the end of a period.

        It follows from the exponential of the system extended by a force f and its slope s: ḟ = s, ṡ = 0.
        """
        extended = np.zeros((6, 4, 4))
        extended[:, 0, 1] = extended[:, 2, 3] = 1.0
        extended[:, 1, 0] = -self.stiffness / self.inertia
        extended[:, 1, 1] = -self.damping / self.inertia
        extended[:, 1, 2] = 1.0 / self.inertia
        transition = _exponential(extended * self.period)[:, :2]
        transition[..., 3] /= self.period  # the slope is the forces' difference over the period
        transition[..., 2] -= transition[..., 3]
        return np.moveaxis(transition, 0, -1).swapaxes(0, 1).copy()


def _exponential(matrix: Array) -> Array:
    """Matrix exponential (..., n, n) by scaling and squaring of its Taylor series; NaN if not finite."""
    size = float(total(np.abs(matrix)).max())
    if not math.isfinite(size):
        return np.full(matrix.shape, np.nan)
    squarings = max(0, math.ceil(math.log2(max(size, 1.0)))) + _SAFE_SQUARINGS
    small = matrix / 2.0**squarings
    term = result = np.broadcast_to(np.eye(matrix.shape[-1]), matrix.shape)
    for order in range(1, _TAYLOR_TERMS):
        term = multiply(term, small) / order
        result = result + term
    for _ in range(squarings):
        result = multiply(result, result)
    return np.array(result)
