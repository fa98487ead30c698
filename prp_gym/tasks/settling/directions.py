"""Components of vectors along and across the desired force of a contact."""

import numpy as np

from prp_gym.robot.arrays import Array, dot, norm
from prp_gym.robot.shared import shared


@shared
def magnitude(vector: Array) -> Array:
    """Norm of a vector at each sample, in its unit: (..., T, 3) -> (..., T)."""
    return norm(vector)


@shared
def _divisor(desired: Array) -> Array:
    """Magnitude of a desired force (..., T, 3) -> (..., T, 1) [N]; NaN where it is zero."""
    size = magnitude(desired)[..., None]
    return np.where(size > 0.0, size, np.nan)


@shared
def _direction(desired: Array) -> Array:
    """Unit vectors along a desired force (..., T, 3); NaN where it is zero."""
    direction: Array = desired / _divisor(desired)
    return direction


@shared
def along_desired(force: Array, desired: Array) -> tuple[Array, Array]:
    """The force in the desired force's direction, and the desired force's magnitude.

    Args:
        force: (..., T, 3) [N].
        desired: (..., T, 3) [N].

    Returns:
        (..., T, 1) [N] each; NaN for the first where no force is desired.
    """
    return dot(force, _direction(desired))[..., None], magnitude(desired)[..., None]


def across_desired(vector: Array, desired: Array) -> Array:
    """The part of a vector perpendicular to the desired force.

    Args:
        vector: (..., T, 3), in any unit.
        desired: Desired force (..., T, 3) [N].

    Returns:
        (..., T, 3), in the vector's unit; NaN where no force is desired.

    Source: [S] 9.4, the directions of force and of motion.
    """
    along, _ = along_desired(vector, desired)
    across: Array = vector - along * desired / _divisor(desired)
    return across
