"""Components of vectors along and across the desired force of a contact."""

import numpy as np

from prp_gym.robot.arrays import Array, dot, norm


def along_desired(force: Array, desired: Array) -> tuple[Array, Array]:
    """The force in the desired force's direction, and the desired force's magnitude.

    Args:
        force: (..., T, 3) [N].
        desired: (..., T, 3) [N].

    Returns:
        (..., T, 1) [N] each; NaN for the first where no force is desired.
    """
    magnitude = norm(desired)[..., None]
    direction = desired / np.where(magnitude > 0.0, magnitude, np.nan)
    return dot(force, direction)[..., None], magnitude


def across_desired(vector: Array, desired: Array) -> Array:
    """The part of a vector perpendicular to the desired force.

    Args:
        vector: (..., T, 3), in any unit.
        desired: Desired force (..., T, 3) [N].

    Returns:
        (..., T, 3), in the vector's unit; NaN where no force is desired.

    Source: [S] 9.4, the directions of force and of motion.
    """
    along, magnitude = along_desired(vector, desired)
    across: Array = vector - along * desired / np.where(magnitude > 0.0, magnitude, np.nan)
    return across
