"""`scoring_of`: how policies on a task are shown in tables and audited."""

from collections.abc import Mapping

from prp_gym.tasks.spec import TASKS, TaskError, TaskScoring

_JOINT_COLUMNS = (
    "joint_rmse",
    "steady_state_error",
    "settling_time",
    "overshoot",
    "energy",
    "saturation",
)
_POSE_COLUMNS = (
    "position_rmse",
    "orientation_rmse",
    "position_steady_state_error",
    "position_settling_time",
    "position_overshoot",
    "energy",
    "saturation",
)
_MODEL_COLUMNS = (
    "model_position_rmse",
    "model_orientation_rmse",
    "peak_force",
    "contact_losses",
    "injected_energy",
    "energy",
    "saturation",
)
_FORCE_COLUMNS = (
    "orientation_rmse",
    "force_rmse",
    "steady_state_force_error",
    "force_settling_time",
    "peak_force",
    "contact_losses",
    "injected_energy",
    "energy",
    "saturation",
)

_JOINTS = (0.02, 0.01, 0.042)  # rad, m, rad: each moves the tip by about 1 cm, from 0.5 m and a_3 = 0.24 m
_ANGLES = (0.042,)  # rad: turns the last link by as much as moves the tip by 1 cm
_CENTIMETRE = (0.01,)  # m

_JOINT = TaskScoring(
    _JOINT_COLUMNS,
    TaskError(
        {"joint_mean_error": _JOINTS},
        "mean error of the joints; each counts as much as the distance by which it moves the tip",
    ),
)
_LINK = TaskScoring(
    _JOINT_COLUMNS, TaskError({"joint_mean_error": _JOINTS[:1]}, "mean position error of the link")
)
_POSE = TaskScoring(
    _POSE_COLUMNS,
    TaskError(
        {"position_mean_error": _CENTIMETRE, "orientation_mean_error": _ANGLES},
        "mean error of the tip's pose; an angle counts as much as the distance by which it moves the end of"
        " the last link",
    ),
)
_MODEL = TaskScoring(
    _MODEL_COLUMNS,
    TaskError(
        {"model_position_mean_error": _CENTIMETRE, "model_orientation_mean_error": _ANGLES},
        "mean deviation of the tip's pose from the reference model that the measured force drives",
    ),
)
_FORCE = TaskScoring(
    _FORCE_COLUMNS,
    TaskError(
        {"force_mean_error": (1.0,), "surface_mean_error": _CENTIMETRE, "orientation_mean_error": _ANGLES},
        "mean errors of force and pose; 1 N, the smallest desired force, counts as much as 1 cm along the"
        " surface; the position along the desired force follows from the force and does not count",
    ),
)

_SCORINGS: Mapping[str, TaskScoring] = {
    "PRP-JointRegulation-v0": _JOINT,
    "PRP-JointTracking-v0": _JOINT,
    "PRP-Adaptive-v0": _LINK,
    "PRP-PoseRegulation-v0": _POSE,
    "PRP-PoseTracking-v0": _POSE,
    "PRP-Compliance-v0": _MODEL,
    "PRP-Impedance-v0": _MODEL,
    "PRP-Admittance-v0": _MODEL,
    "PRP-Force-v0": _FORCE,
    "PRP-ForcePosition-v0": _FORCE,
}
"""Of the tasks that have no `TaskSpec` yet."""


def scoring_of(environment_id: str) -> TaskScoring:
    """Columns of the tables and physical error of a task, as its declaration states them.

    Args:
        environment_id: of an environment, declared or not.

    Returns:
        the declared scoring; one without columns and error where the task is not declared.
    """
    if environment_id in TASKS:
        return TASKS[environment_id].scoring
    return _SCORINGS.get(environment_id, TaskScoring())
