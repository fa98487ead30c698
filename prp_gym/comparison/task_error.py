"""Which physical error of a task its reward stands for.

Every gauge is a mean over time of absolute errors (IAE over the duration): it counts how large an error is as
well as how long it lasts, each centimetre the same, so it needs no scale but for bringing angles and forces
to one unit with lengths. The root mean square would be that of one impact, or of the first distance to the
goal, which is the same for all policies; a median would leave out whatever takes less than half of the time,
as contact may; an error after the transient would leave out the transient, which is what regulation is about.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from prp_gym.comparison.values import Entry
from prp_gym.robot.arrays import Array


@dataclass(frozen=True)
class TaskError:
    """The physical error of a task: the sum of some metrics, each in units of what counts as much as others.

    Attributes:
        parts: by metric, the values of its components that count the same.
        reason: why it is this error.
    """

    parts: Mapping[str, tuple[float, ...]]
    reason: str

    @property
    def name(self) -> str:
        """For tables."""
        return " + ".join(self.parts)


_JOINTS = (0.02, 0.01, 0.042)
"""[rad, m, rad]: each moves the tip by about 1 cm, joint 1 being 0.5 m and joint 3 a_3 = 0.24 m from it."""

_ANGLES = (0.042,)
"""[rad]: what turns the last link by as much as moves the tip by 1 cm."""

_CENTIMETRE = (0.01,)
_POSE = TaskError(
    {"position_mean_error": _CENTIMETRE, "orientation_mean_error": _ANGLES},
    "how far the tip is off on average, an angle as far as it moves the end of the last link",
)
_JOINT = TaskError(
    {"joint_mean_error": _JOINTS}, "how far the joints are off on average, each as far as it moves the tip"
)
_MODEL = TaskError(
    {"model_position_mean_error": _CENTIMETRE, "model_orientation_mean_error": _ANGLES},
    "how far the tip is on average from the reference model that the measured force drives",
)
_FORCE = TaskError(
    {"force_mean_error": (1.0,), "surface_mean_error": _CENTIMETRE, "orientation_mean_error": _ANGLES},
    "the force on average, 1 N of it, the least that is asked for, as much as 1 cm along the surface;"
    " along the force the position is what the force makes it",
)

TASK_ERRORS: Mapping[str, TaskError] = {
    "PRP-JointRegulation-v0": _JOINT,
    "PRP-JointTracking-v0": _JOINT,
    "PRP-Adaptive-v0": TaskError({"joint_mean_error": _JOINTS[:1]}, "how far the link is off on average"),
    "PRP-PoseRegulation-v0": _POSE,
    "PRP-PoseTracking-v0": _POSE,
    "PRP-Compliance-v0": _MODEL,
    "PRP-Impedance-v0": _MODEL,
    "PRP-Admittance-v0": _MODEL,
    "PRP-Force-v0": _FORCE,
    "PRP-ForcePosition-v0": _FORCE,
}
"""The physical error of each environment, in physical units and without the reward's scales and kernel."""


def physical_errors(entry: Entry, task_error: TaskError) -> Array:
    """A policy's error in every episode; infinite where it diverged.

    Args:
        entry: a policy at a place.
        task_error: of the place's environment.

    Returns:
        (rows, evaluation seeds), in units of the gauge's scales.
    """
    shares = [
        (np.abs(entry.metrics[name]) / np.array(scale)).sum(-1) for name, scale in task_error.parts.items()
    ]
    error: Array = np.sum(shares, axis=0)
    return np.where(np.isnan(error), np.inf, error)
