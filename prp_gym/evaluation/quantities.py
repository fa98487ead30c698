"""Units of what an episode records, by name."""

from prp_gym.tasks.fields import (
    CONTACT_FORCE,
    DESIRED_FORCE,
    FORCE_ERROR,
    JOINT_REFERENCE_FIELDS,
    MEASURED_FIELDS,
    MODEL_POSE,
    POSE_REFERENCE_FIELDS,
)

_TORQUE_UNITS = ("N m", "N", "N m")
_FIELDS = (*MEASURED_FIELDS, CONTACT_FORCE, *JOINT_REFERENCE_FIELDS, *POSE_REFERENCE_FIELDS)

UNITS = {
    **{field.name: field.units for field in (*_FIELDS, DESIRED_FORCE, MODEL_POSE, FORCE_ERROR)},
    "time": ("s",),
    "torque": _TORQUE_UNITS,
    "applied_torque": _TORQUE_UNITS,
    "reward": ("1",),
}
"""Units of the components; the single link has the first one alone."""
