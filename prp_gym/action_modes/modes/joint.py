"""Action modes that move the reference of joint-space controllers."""

from prp_gym.action_modes.commanded import CommandInputs
from prp_gym.envs.action_mode import ActionField, ActionModeSpec, register_action_mode

JOINT_OFFSET = ActionField(
    "joint_offset",
    ("rad", "m", "rad"),
    "joint",
    (0.3, 0.05, 0.3),
    "added to the desired joint position q_d",
)

register_action_mode(
    ActionModeSpec(
        name="joint_position",
        summary="moves the reference of joint PD control",
        entry=CommandInputs("joint_pd", (JOINT_OFFSET,)),
        chapter=6,
    )
)
register_action_mode(
    ActionModeSpec(
        name="joint_inverse_dynamics",
        summary="moves the reference of joint-space inverse dynamics",
        entry=CommandInputs("joint_inverse_dynamics", (JOINT_OFFSET,)),
        chapter=7,
    )
)
