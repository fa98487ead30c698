"""Columns of the result tables and physical errors for the reward audit, by family of tasks.

Every physical error is the mean over time of absolute errors (the IAE divided by the duration). It weighs the
size of an error and its duration linearly, so that scales only convert angles and forces to the unit of
lengths. A root mean square would be dominated by one impact or by the initial distance to the goal, which
is the same for all policies; a median would ignore whatever takes less than half of the episode, as contact
may; an error after the transient would ignore the transient, which is the substance of regulation.
"""

from prp_gym.tasks.spec import TaskError, TaskScoring

_JOINTS = (0.02, 0.01, 0.042)  # rad, m, rad: each moves the tip by about 1 cm, from 0.5 m and a_3 = 0.24 m
_ANGLES = (0.042,)  # rad: the rotation of the last link that moves the tip by 1 cm
_CENTIMETRE = (0.01,)
_EFFORT = ("energy", "saturation")
_CONTACT = ("peak_force", "contact_losses", "injected_energy")
_JOINT_COLUMNS = ("joint_rmse", "steady_state_error", "settling_time", "overshoot", *_EFFORT)

JOINT_SCORING = TaskScoring(
    _JOINT_COLUMNS,
    TaskError(
        {"joint_mean_error": _JOINTS},
        "mean error of the joints; each counts as much as the distance by which it moves the tip",
    ),
)
LINK_SCORING = TaskScoring(
    _JOINT_COLUMNS, TaskError({"joint_mean_error": _JOINTS[:1]}, "mean position error of the link")
)
POSE_SCORING = TaskScoring(
    (
        "position_rmse",
        "orientation_rmse",
        "position_steady_state_error",
        "position_settling_time",
        "position_overshoot",
        *_EFFORT,
    ),
    TaskError(
        {"position_mean_error": _CENTIMETRE, "orientation_mean_error": _ANGLES},
        "mean error of the tip's pose; an angle counts as much as the distance by which it moves the end of"
        " the last link",
    ),
)
TARGET_SCORING = TaskScoring(
    ("model_position_rmse", "model_orientation_rmse", *_CONTACT, *_EFFORT),
    TaskError(
        {"model_position_mean_error": _CENTIMETRE, "model_orientation_mean_error": _ANGLES},
        "mean deviation of the tip's pose from the reference model that the measured force drives",
    ),
)
FORCE_SCORING = TaskScoring(
    (
        "orientation_rmse",
        "force_rmse",
        "steady_state_force_error",
        "force_settling_time",
        *_CONTACT,
        *_EFFORT,
    ),
    TaskError(
        {"force_mean_error": (1.0,), "surface_mean_error": _CENTIMETRE, "orientation_mean_error": _ANGLES},
        "mean errors of force and pose; 1 N, the smallest desired force, counts as much as 1 cm along the"
        " surface; the position along the desired force follows from the force and does not count",
    ),
)
