"""The action modes that add to the torques of a controller."""

from prp_gym.action_modes.residual import ResidualTorque
from prp_gym.envs.action_mode import ActionModeSpec, register_action_mode

register_action_mode(
    ActionModeSpec(
        name="residual",
        summary="adds to the controller's torques",
        entry=ResidualTorque(),
    )
)
