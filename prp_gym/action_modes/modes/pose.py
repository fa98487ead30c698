"""Action modes that move the reference of operational-space controllers."""

from prp_gym.action_modes.commanded import CommandInputs
from prp_gym.envs.action_mode import ActionField, ActionModeSpec, register_action_mode

POSE_OFFSET = ActionField(
    "pose_offset",
    ("m", "m", "m", "rad", "rad"),
    "world",
    (0.05, 0.05, 0.05, 0.3, 0.3),
    "added to x, y, z, α, β of the desired pose x_d",
)

register_action_mode(
    ActionModeSpec(
        name="operational_position",
        summary="moves the reference of operational-space PD control",
        entry=CommandInputs("operational_pd", (POSE_OFFSET,)),
        chapter=9,
    )
)
register_action_mode(
    ActionModeSpec(
        name="admittance",
        summary="moves the reference of admittance control",
        entry=CommandInputs("admittance", (POSE_OFFSET,)),
        chapter=13,
    )
)
