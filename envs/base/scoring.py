"""Columns of the result tables, criteria for the audit of the reward, settling criteria, by family of tasks.

A response to a goal has settled within 2 % of the whole move, and at least within 1 mm; one to a moving
reference or to a target model within 1 cm at the tip. Near a target model it also has to settle before the
planned reference turns back: at the end, out of contact, a stiff arm is near every target, however far from
it the arm was in contact. A force has settled within 5 % of the desired one, and at least within 0.2 N: the
force sensor of scenario `realistic` has a bias of up to 0.1 N on each axis, 0.17 N along a normal that is
oblique to all three, so that nobody can hold 1 N within 2 %.
"""

from prp_gym.tasks.settling.displacements import ANGLE_CENTIMETRE, JOINT_CENTIMETRE, POSITION_CENTIMETRE
from prp_gym.tasks.settling.force_settling import ForceSettling
from prp_gym.tasks.settling.motion_settling import MotionSettling
from prp_gym.tasks.spec import Criterion, TaskScoring

_POSE = (*POSITION_CENTIMETRE, ANGLE_CENTIMETRE, ANGLE_CENTIMETRE)
_EFFORT = ("energy", "saturation")
_SETTLING = (Criterion("response_settling_time", 5.0), Criterion("unsettled", 100.0))
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
    (*_SETTLING, Criterion("overshoot", 100.0, required=False)),
    _joint_settling(JOINT_CENTIMETRE),
)
LINK_SCORING = TaskScoring(
    _JOINT_COLUMNS,
    _SETTLING,
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
    (*_SETTLING, Criterion("position_overshoot", 100.0, required=False)),
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
    (*_SETTLING, Criterion("peak_force", 50.0)),
    MotionSettling(
        "end_effector_pose",
        "model_pose",
        "desired_pose",
        _POSE,
        moving=1.0,
        resting=1.0,
        before_reversals=True,
    ),
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
    (*_SETTLING, Criterion("peak_force_ratio", 300.0)),
    ForceSettling(share=0.05, least=0.2, position=POSITION_CENTIMETRE[0], angle=ANGLE_CENTIMETRE),
)
