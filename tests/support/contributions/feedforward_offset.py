"""Action mode that moves the reference of PD control with feedforward."""

from prp_gym.action_modes.commanded import CommandInputs
from prp_gym.envs.action_mode import ActionField, ActionModeSpec, register_action_mode

OFFSET = ActionField(
    "joint_offset",
    ("rad", "m", "rad"),
    "joint",
    (0.1, 0.02, 0.1),
    "added to the desired joint position q_d",
)

register_action_mode(
    ActionModeSpec(
        name="feedforward_offset",
        summary="moves the reference of PD control with feedforward",
        entry=CommandInputs("joint_feedforward", (OFFSET,)),
    )
)
