"""The elastic surface: a plane that pushes back on the tip as a spring and damper, on one side only."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from prp_gym.errors import InvalidValueError, ShapeError
from prp_gym.robot.arrays import Array

IMPEDANCE = 1e-4
"""d of MuJoCo's solimp, its smallest value: it leaves d/((1-d)Â), 0.13 g here, as a spurious added mass."""


IMPEDANCE_RATIO = 3000.0
"""MuJoCo's impratio in worlds with friction: so stiff a friction leaves the normal force alone."""

_FRICTION_DAMPING = 300.0  # [N s/m]: below a slip speed of mu f_n / this, friction is viscous


@dataclass(frozen=True, eq=False)
class Surface:
    """Elastic planes, one per simulation: the points p with normal·p = offset.

    The free side is normal·p > offset. With depth = offset - normal·tip and rate its derivative, the
    tip presses with max(0, stiffness·depth + damping·rate) while depth > 0, and nothing otherwise.

    Attributes:
        stiffness: K (n) [N/m], above 0.
        damping: D (n) [N s/m], at least 0.
        normal: (n, 3) unit vectors in the world frame, out of the surface to the free side.
        offset: (n) distance of the plane from the world's origin along the normal [m].

    Raises:
        InvalidValueError: a stiffness that is not positive, negative damping, a zero normal, a value
            that is not finite.
        ShapeError: arrays of different length.
    """

    stiffness: Array
    damping: Array
    normal: Array
    offset: Array

    def __post_init__(self) -> None:
        for name in ("stiffness", "damping", "normal", "offset"):
            own = np.array(getattr(self, name), dtype=np.float64)
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
        scaled = self.normal / largest[:, None]  # so that the squares neither vanish nor overflow
        normal = scaled / np.linalg.norm(scaled, axis=-1, keepdims=True)
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
            np.array([stiffness]),
            np.array([damping]),
            np.array([normal], dtype=np.float64),
            np.array([offset]),
        )

    @classmethod
    def concatenate(cls, surfaces: Sequence["Surface"]) -> "Surface":
        """The planes of several, in order."""
        return cls(
            np.concatenate([surface.stiffness for surface in surfaces]),
            np.concatenate([surface.damping for surface in surfaces]),
            np.concatenate([surface.normal for surface in surfaces]),
            np.concatenate([surface.offset for surface in surfaces]),
        )

    def quaternions(self) -> Array:
        """(n, 4) rotations (w, x, y, z) that turn the z axis into the normals."""
        x, y, z = self.normal[:, 0], self.normal[:, 1], self.normal[:, 2]
        quaternion = np.stack([1.0 + z, -y, x, np.zeros_like(z)], axis=-1)
        down = z < -1.0 + 1e-12
        quaternion[down] = (0.0, 1.0, 0.0, 0.0)
        unit: Array = quaternion / np.linalg.norm(quaternion, axis=-1, keepdims=True)
        return unit


def friction_reference(inverse_weight: Array) -> Array:
    """MuJoCo's `solreffriction` that makes the surface's friction stiff whatever the surface's damping.

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
