"""The elastic surface: a plane that acts on the tip as a unilateral spring and damper."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from prp_gym.checks import as_numbers, check_finite
from prp_gym.errors import InvalidValueError, ShapeError
from prp_gym.robot.arrays import Array, norm

CONTACT_THRESHOLD = 1e-6
"""Contact force above which the tip is in contact [N], that of 1 µm into a surface of 1 N/m."""

IMPEDANCE = 1e-4
"""Smallest value of d in MuJoCo's solimp; it causes a spurious added mass of d/((1-d)Â), here 0.13 g."""


IMPEDANCE_RATIO = 3000.0
"""MuJoCo's impratio in worlds with friction; with such a stiff friction the normal force is not affected."""

_FRICTION_DAMPING = 300.0  # [N s/m]: below a slip speed of mu f_n / this, friction is viscous


@dataclass(frozen=True, eq=False)
class Surface:
    """Elastic planes normal·p = offset, one per simulation.

    The free side is normal·p > offset. With depth = offset - normal·tip and rate its derivative, the
    tip presses with max(0, stiffness·depth + damping·rate) while depth > 0, and nothing otherwise.

    Attributes:
        stiffness: Stiffness K (n) [N/m], above 0.
        damping: Damping D (n) [N s/m], at least 0.
        normal: Unit vectors (n, 3) in the world frame that point out of the surface to the free side.
        offset: Distance (n) of the plane from the world's origin along the normal [m].

    Raises:
        InvalidValueError: a stiffness that is not positive, negative damping, a zero normal, a value
            that is not finite.
        ShapeError: arrays have different lengths.
    """

    stiffness: Array
    damping: Array
    normal: Array
    offset: Array

    def __post_init__(self) -> None:
        for name in ("stiffness", "damping", "normal", "offset"):
            own = as_numbers(f"surface {name}", getattr(self, name))
            own.flags.writeable = False
            object.__setattr__(self, name, own)
        count = self.stiffness.shape[0] if self.stiffness.ndim == 1 else 0
        for name in ("stiffness", "damping", "normal", "offset"):
            shape = (count, 3) if name == "normal" else (count,)
            if count == 0 or getattr(self, name).shape != shape:
                expected = "(n, 3)" if name == "normal" else "(n,), n at least 1"
                raise ShapeError(f"surface {name}", getattr(self, name).shape, expected)
        self._require("stiffness", self.stiffness > 0.0, "above 0", "N/m")
        self._require("damping", self.damping >= 0.0, "at least 0", "N·s/m")
        largest = np.abs(self.normal).max(axis=-1)
        self._require("normal", largest > 0.0, "a vector of positive length", "")
        self._require("offset", np.isfinite(self.offset), "a finite number", "m")
        for name in ("stiffness", "damping", "offset"):
            check_finite(f"surface {name}", getattr(self, name))
        scaled = self.normal / largest[:, None]  # so that the squares neither underflow nor overflow
        normal = scaled / norm(scaled)[:, None]
        normal.flags.writeable = False
        object.__setattr__(self, "normal", normal)

    def _require(self, name: str, good: NDArray[np.bool_], allowed: str, unit: str) -> None:
        values = getattr(self, name)
        good = good & np.isfinite(values).reshape(len(good), -1).all(axis=1)
        if not good.all():
            raise InvalidValueError(
                f"surface {name}", values[~good][0].tolist(), f"{allowed} and finite", unit
            )

    @classmethod
    def single(
        cls, stiffness: float, normal: tuple[float, float, float], offset: float, damping: float = 0.0
    ) -> "Surface":
        """One plane, for one simulation; units as in the class."""
        return cls(
            np.atleast_1d(as_numbers("surface stiffness", stiffness, "N/m")),
            np.atleast_1d(as_numbers("surface damping", damping, "N·s/m")),
            np.atleast_2d(as_numbers("surface normal", normal)),
            np.atleast_1d(as_numbers("surface offset", offset, "m")),
        )

    @classmethod
    def concatenate(cls, surfaces: Sequence["Surface"]) -> "Surface":
        """Surface with the planes of several surfaces, in order."""
        return cls(
            np.concatenate([surface.stiffness for surface in surfaces]),
            np.concatenate([surface.damping for surface in surfaces]),
            np.concatenate([surface.normal for surface in surfaces]),
            np.concatenate([surface.offset for surface in surfaces]),
        )

    def quaternions(self) -> Array:
        """Quaternions (n, 4) (w, x, y, z) that rotate the z axis into the normals."""
        x, y, z = self.normal[:, 0], self.normal[:, 1], self.normal[:, 2]
        quaternion = np.stack([1.0 + z, -y, x, np.zeros_like(z)], axis=-1)
        down = z < -1.0 + 1e-12
        quaternion[down] = (0.0, 1.0, 0.0, 0.0)
        unit: Array = quaternion / norm(quaternion)[:, None]
        return unit


def friction_reference(inverse_weight: Array) -> Array:
    """MuJoCo's `solreffriction` that makes the friction stiff for every damping of the surface.

    Args:
        inverse_weight: (n) `body_invweight0` (translation) of the tip's body [1/kg].

    Returns:
        (n, 2).

    Source: [M] Computation, Solver parameters.
    """
    damping = _FRICTION_DAMPING * inverse_weight * (1.0 - IMPEDANCE) / IMPEDANCE_RATIO
    return np.stack([np.zeros_like(damping), -damping], axis=-1)


def solver_reference(stiffness: Array, damping: Array, inverse_weight: Array) -> Array:
    """MuJoCo's `solref` that makes a contact a spring and damper.

    Args:
        stiffness: K (n) [N/m].
        damping: D (n) [N s/m].
        inverse_weight: (n) `body_invweight0` (translation) of the tip's body [1/kg].

    Returns:
        (n, 2).

    Source: [M] Computation, Solver parameters: with impedance d and R = (1-d)/d Â, direct coefficients
        (-K Â (1-d), -D Â (1-d)) give the normal force K depth + D rate.
    """
    scale = -inverse_weight * (1.0 - IMPEDANCE)
    return np.stack([stiffness * scale, damping * scale], axis=-1)
