"""Action modes that move the references of parallel force/position control, or set its rates."""

from dataclasses import replace

from prp_gym.action_modes.commanded import CommandInputs
from prp_gym.action_modes.modes.pose import POSE_OFFSET
from prp_gym.envs.action_mode import ActionField, ActionModeSpec, register_action_mode

STIFF_POSE_OFFSET = replace(POSE_OFFSET, bound=(0.005, 0.005, 0.005, 0.05, 0.05))
"""A smaller one: 5 mm are 25 N on the stiffest surface."""

FORCE_OFFSET = ActionField(
    "force_offset",
    ("N",) * 3,
    "world",
    (2.0, 2.0, 2.0),
    "added to the desired force f_d by the tip",
)
APPROACH_FACTOR = ActionField(
    "approach_speed_factor",
    ("1",),
    "along f_d",
    (10.0,),
    "times the controller's speed towards a surface",
    factor=True,
)
BANDWIDTH_FACTOR = ActionField(
    "bandwidth_factor",
    ("1",),
    "along f_d",
    (4.0,),
    "times the controller's bandwidth in contact",
    factor=True,
)

register_action_mode(
    ActionModeSpec(
        name="force_position",
        summary="moves position and force of parallel force/position control",
        entry=CommandInputs("parallel_force_position", (STIFF_POSE_OFFSET, FORCE_OFFSET)),
        chapter=15,
    )
)
register_action_mode(
    ActionModeSpec(
        name="variable_force_position",
        summary="sets how fast parallel force/position control approaches and corrects",
        entry=CommandInputs("parallel_force_position", (APPROACH_FACTOR, BANDWIDTH_FACTOR)),
        chapter=15,
    )
)
