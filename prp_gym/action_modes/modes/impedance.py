"""Action modes that move the reference of impedance control and set its stiffness and damping."""

from prp_gym.action_modes.commanded import CommandInputs
from prp_gym.action_modes.modes.pose import POSE_OFFSET
from prp_gym.envs.action_mode import ActionField, ActionModeSpec, register_action_mode

STIFFNESS_FACTOR = ActionField(
    "stiffness_factor",
    ("1",) * 5,
    "world",
    (10.0,) * 5,
    "times the controller's K_P along x, y, z, α, β; K_D follows, so that the damping ratio stays",
    factor=True,
)
DAMPING_FACTOR = ActionField(
    "damping_factor",
    ("1",) * 5,
    "world",
    (4.0,) * 5,
    "times the controller's damping ratio along x, y, z, α, β",
    factor=True,
)

register_action_mode(
    ActionModeSpec(
        name="impedance",
        summary="moves the reference of impedance control",
        entry=CommandInputs("impedance", (POSE_OFFSET,)),
        chapter=12,
    )
)
register_action_mode(
    ActionModeSpec(
        name="variable_stiffness",
        summary="moves the reference of impedance control and sets its stiffness",
        entry=CommandInputs("impedance", (POSE_OFFSET, STIFFNESS_FACTOR)),
        chapter=12,
    )
)
register_action_mode(
    ActionModeSpec(
        name="variable_impedance",
        summary="moves the reference of impedance control and sets its stiffness and damping",
        entry=CommandInputs("impedance", (POSE_OFFSET, STIFFNESS_FACTOR, DAMPING_FACTOR)),
        chapter=12,
    )
)
