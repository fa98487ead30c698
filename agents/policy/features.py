"""Input of a policy network: the observation and the tracking errors that it implies."""

import numpy as np
from numpy.typing import ArrayLike

from prp_gym.robot.arrays import Array
from prp_gym.tasks.fields import ObservationLayout

_TRACKED = (
    ("desired_joint_position", "joint_position"),
    ("desired_joint_velocity", "joint_velocity"),
    ("desired_pose", "end_effector_pose"),
    ("desired_velocity", "end_effector_velocity"),
    ("desired_force", "contact_force"),
)
"""Observation fields: a reference, and the measurement that should follow it."""


class TrackingFeatures:
    """An observation followed by the tracking error reference - measurement of every quantity that has both.

    Once features are normalised to unit variance, an error of a millimetre is lost in a position that varies
    by decimetres; as a feature it has a scale of its own. All features are functions of the observation.

    Args:
        layout: layout of the observation.

    Attributes:
        names: names of the parts of the features, in order.
        size: number of features.
    """

    def __init__(self, layout: ObservationLayout) -> None:
        self._layout = layout
        present = [fields for fields in _TRACKED if set(fields) <= set(layout.names)]
        self._slices = [(layout.index(desired), layout.index(measured)) for desired, measured in present]
        self.names = (*layout.names, *(f"{measured}_error" for _, measured in present))
        self.size = layout.size + sum(part.stop - part.start for part, _ in self._slices)

    def __call__(self, observation: ArrayLike) -> Array:
        """The features (..., size) of observations (..., layout size)."""
        flat = np.asarray(observation, dtype=np.float64)
        errors = [flat[..., desired] - flat[..., measured] for desired, measured in self._slices]
        return np.concatenate([flat, *errors], axis=-1)
