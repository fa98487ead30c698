"""Columns of the result tables, physical errors for the reward audit, settling criteria, by family of tasks.

Every physical error is the mean over time of absolute errors (the IAE divided by the duration). It weighs the
size of an error and its duration linearly, so that scales only convert angles and forces to the unit of
lengths. A root mean square would be dominated by one impact or by the initial distance to the goal, which
is the same for all policies; a median would ignore whatever takes less than half of the episode, as contact
may; an error after the transient would ignore the transient, which is the substance of regulation.

A response to a goal has settled within 2 % of the whole move, and at least within 1 mm; one to a moving
reference or to a target model within 1 cm at the tip. A force has settled within 5 % of the desired one, and
at least within 0.2 N: the force sensor of scenario `realistic` has a bias of up to 0.1 N on each axis, 0.17 N
along a normal that is oblique to all three, so that nobody can hold 1 N within 2 %.
"""

from prp_gym.tasks.settling.displacements import ANGLE_CENTIMETRE, JOINT_CENTIMETRE, POSITION_CENTIMETRE
from prp_gym.tasks.settling.force_settling import ForceSettling
from prp_gym.tasks.settling.motion_settling import MotionSettling
from prp_gym.tasks.spec import TaskError, TaskScoring

_ANGLES = (ANGLE_CENTIMETRE,)
_CENTIMETRE = (POSITION_CENTIMETRE[0],)
_POSE = (*POSITION_CENTIMETRE, ANGLE_CENTIMETRE, ANGLE_CENTIMETRE)
_EFFORT = ("energy", "saturation")
_JOINT_COLUMNS = ("joint_rmse", "steady_state_error", "response_settling_time", "overshoot", *_EFFORT)


def _joint_settling(centimetre: tuple[float, ...]) -> MotionSettling:
    return MotionSettling(
        "joint_position",
        "desired_joint_position",
        "desired_joint_position",
        centimetre,
        moving=1.0,
        resting=0.1,
        share=0.02,
    )


JOINT_SCORING = TaskScoring(
    _JOINT_COLUMNS,
    TaskError(
        {"joint_mean_error": JOINT_CENTIMETRE},
        "mean error of the joints; each counts as much as the distance by which it moves the tip",
    ),
    _joint_settling(JOINT_CENTIMETRE),
)
LINK_SCORING = TaskScoring(
    _JOINT_COLUMNS,
    TaskError({"joint_mean_error": JOINT_CENTIMETRE[:1]}, "mean position error of the link"),
    _joint_settling(JOINT_CENTIMETRE[:1]),
)
POSE_SCORING = TaskScoring(
    (
        "position_rmse",
        "orientation_rmse",
        "position_steady_state_error",
        "response_settling_time",
        "position_overshoot",
        *_EFFORT,
    ),
    TaskError(
        {"position_mean_error": _CENTIMETRE, "orientation_mean_error": _ANGLES},
        "mean error of the tip's pose; an angle counts as much as the distance by which it moves the end of"
        " the last link",
    ),
    MotionSettling(
        "end_effector_pose", "desired_pose", "desired_pose", _POSE, moving=1.0, resting=0.1, share=0.02
    ),
)
TARGET_SCORING = TaskScoring(
    (
        "model_position_rmse",
        "model_orientation_rmse",
        "response_settling_time",
        "peak_force",
        "contact_losses",
        "injected_energy",
        *_EFFORT,
    ),
    TaskError(
        {"model_position_mean_error": _CENTIMETRE, "model_orientation_mean_error": _ANGLES},
        "mean deviation of the tip's pose from the reference model that the measured force drives",
    ),
    MotionSettling("end_effector_pose", "model_pose", "desired_pose", _POSE, moving=1.0, resting=1.0),
)
FORCE_SCORING = TaskScoring(
    (
        "orientation_rmse",
        "force_rmse",
        "steady_state_force_error",
        "response_settling_time",
        "peak_force_ratio",
        "contact_losses",
        *_EFFORT,
    ),
    TaskError(
        {"force_mean_error": (1.0,), "surface_mean_error": _CENTIMETRE, "orientation_mean_error": _ANGLES},
        "mean errors of force and pose; 1 N, the smallest desired force, counts as much as 1 cm along the"
        " surface; the position along the desired force follows from the force and does not count",
    ),
    ForceSettling(share=0.05, least=0.2, position=POSITION_CENTIMETRE[0], angle=ANGLE_CENTIMETRE),
)
