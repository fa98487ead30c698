"""What the tests of the joint-space laws give them for an environment."""

import numpy as np

from prp_gym.baselines import ControlInterface
from prp_gym.tasks.fields import JOINT_REFERENCE_FIELDS, MEASURED_FIELDS, ObservationLayout

INTERFACE = ControlInterface(
    "PRP-JointTracking-v0",
    ObservationLayout((*MEASURED_FIELDS, *JOINT_REFERENCE_FIELDS)),
    np.array([50.0, 100.0, 10.0]),
    0.002,
)
