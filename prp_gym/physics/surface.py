"""The elastic surface: a plane that acts on the tip as a unilateral spring and damper."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from prp_gym.checks import LARGEST, as_numbers, check_finite
from prp_gym.errors import InvalidValueError, ShapeError
from prp_gym.robot.arrays import Array, norm, zeros

CONTACT_THRESHOLD = 1e-6
"""Contact force above which the tip is in contact [N], that of 1 µm into a surface of 1 N/m."""

IMPEDANCE = 1e-4
"""Smallest value of d in MuJoCo's solimp; it causes a spurious added mass of d/((1-d)Â), here 0.13 g."""


IMPEDANCE_RATIO = 3000.0
"""MuJoCo's impratio in worlds with friction; with such a stiff friction the normal force is not affected."""

_LEAST = np.array([[1e-300], [0.0], [1e-300], [0.0]])  # usual stiffness, damping, normal and offset
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
        own = {name: as_numbers(f"surface {name}", value) for name, value in vars(self).items()}
        count = len(own["stiffness"]) if own["stiffness"].ndim == 1 else 0
        for name, values in own.items():
            if count == 0 or values.shape != ((count, 3) if name == "normal" else (count,)):
                expected = "(n, 3)" if name == "normal" else "(n,), n at least 1"
                raise ShapeError(f"surface {name}", values.shape, expected)
            values.flags.writeable = False
        vars(self).update(own)
        if count == 1 and self._is_usual_plane():
            self._normalise_plane()
            return
        largest = np.abs(self.normal).max(axis=-1)
        values = np.array([self.stiffness, self.damping, largest, np.abs(self.offset)])
        usual = (values >= _LEAST) & (values <= LARGEST)
        if np.count_nonzero(usual) < usual.size:
            self._check(largest)
        self._normalise(largest)

    def _is_usual_plane(self) -> bool:
        """Whether this is a single plane with usual values, whose numbers are faster than arrays."""
        (x, y, z), offset = self.normal[0].tolist(), self.offset.item()
        return (
            1e-300 <= self.stiffness.item() <= LARGEST
            and 0.0 <= self.damping.item() <= LARGEST
            and 1e-300 <= abs(x) + abs(y) + abs(z) <= LARGEST
            and -LARGEST <= offset <= LARGEST
        )

    def _normalise_plane(self) -> None:
        """Scale the normal of a single plane to unit length, with the bits of `_normalise`."""
        numbers = self.normal[0].tolist()
        largest = max(map(abs, numbers))
        x, y, z = (number / largest for number in numbers)
        length = math.sqrt(x * x + y * y + z * z)
        self._keep_normal(np.array([[x / length, y / length, z / length]]))

    def _check(self, largest: Array) -> None:
        """Refuse values that are not allowed; those beyond the usual ones may be.

        Args:
            largest: The largest components of the normals (n).
        """
        self._require("stiffness", self.stiffness > 0.0, "above 0", "N/m")
        self._require("damping", self.damping >= 0.0, "at least 0", "N·s/m")
        self._require("normal", largest > 0.0, "a vector of positive length", "")
        self._require("offset", np.isfinite(self.offset), "a finite number", "m")
        for name in ("stiffness", "damping", "offset"):
            check_finite(f"surface {name}", getattr(self, name))

    def _normalise(self, largest: Array) -> None:
        """Scale the normals to unit length.

        Args:
            largest: Their largest components (n), without which squares may underflow or overflow.
        """
        scaled = self.normal / largest[:, None]
        self._keep_normal(scaled / norm(scaled)[:, None])

    def _keep_normal(self, normal: Array) -> None:
        """Keep normals of unit length."""
        normal.flags.writeable = False
        vars(self)["normal"] = normal

    def _require(self, name: str, good: NDArray[np.bool_], allowed: str, unit: str) -> None:
        values = getattr(self, name)
        bad = ~(good & np.isfinite(values).reshape(len(good), -1).all(axis=1))
        if bad.any():
            raise InvalidValueError(f"surface {name}", values[bad][0].tolist(), f"{allowed} and finite", unit)

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

    def normalised_again(self) -> "Surface":
        """The same planes, their normals scaled to unit length once more, which rounds their lengths less."""
        again = object.__new__(Surface)  # without the checks, which these planes have passed
        vars(again).update(vars(self))
        if len(self.normal) == 1:
            again._normalise_plane()
        else:
            again._normalise(np.abs(self.normal).max(axis=-1))
        return again

    def quaternions(self) -> Array:
        """Quaternions (n, 4) (w, x, y, z) that rotate the z axis into the normals."""
        return quaternions(self.normal)


def quaternions(normal: Array) -> Array:
    """Quaternions (n, 4) (w, x, y, z) that rotate the z axis into unit vectors (n, 3)."""
    x, y, z = (normal[:, axis] for axis in range(3))
    down = z < -1.0 + 1e-12
    columns = [np.where(down, 0.0, 1.0 + z), np.where(down, 1.0, -y), np.where(down, 0.0, x)]
    quaternion = np.stack([*columns, zeros(z.shape, z)], axis=-1)
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
    reference = zeros((len(damping), 2), damping)
    reference[:, 1] = -damping
    return reference


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
    reference = zeros((len(scale), 2), scale)
    reference[:, 0], reference[:, 1] = stiffness * scale, damping * scale
    return reference
