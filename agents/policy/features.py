"""What a network is given: the observation, and beside it the errors that any control law begins with."""

import numpy as np
from numpy.typing import ArrayLike

from prp_gym.robot.arrays import Array
from prp_gym.tasks.fields import ObservationLayout

_PAIRS = (
    ("desired_joint_position", "joint_position"),
    ("desired_joint_velocity", "joint_velocity"),
    ("desired_pose", "end_effector_pose"),
    ("desired_velocity", "end_effector_velocity"),
    ("desired_force", "contact_force"),
)
"""What is desired, and what is measured of it."""


class TrackingFeatures:
    """An observation followed by every difference desired - measured of which it holds both.

    An error of a millimetre is lost in a position that varies by decimetres once both are scaled to unit
    variance; as a feature of its own it has its own scale. Nothing is added that is not in the observation.

    Args:
        layout: of the observation.

    Attributes:
        names: of the features' parts, in order.
        size: number of features.
    """

    def __init__(self, layout: ObservationLayout) -> None:
        self._layout = layout
        present = [pair for pair in _PAIRS if set(pair) <= set(layout.names)]
        self._slices = [(layout.index(desired), layout.index(measured)) for desired, measured in present]
        self.names = (*layout.names, *(f"{measured}_error" for _, measured in present))
        self.size = layout.size + sum(part.stop - part.start for part, _ in self._slices)

    def __call__(self, observation: ArrayLike) -> Array:
        """The features (..., size) of observations (..., layout size)."""
        flat = np.asarray(observation, dtype=np.float64)
        errors = [flat[..., desired] - flat[..., measured] for desired, measured in self._slices]
        return np.concatenate([flat, *errors], axis=-1)
