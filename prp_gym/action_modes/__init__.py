"""Action modes other than `torque`: controllers that an action commands, made for environments."""

from prp_gym.action_modes.commanded import SMOOTHING_TIME, CommandedController, CommandInputs
from prp_gym.action_modes.residual import RESIDUAL_SHARE, ResidualController, ResidualTorque
from prp_gym.envs.action_mode import (
    ACTION_MODES,
    ANY_CONTROLLER,
    ActionField,
    ActionModeSpec,
    ModeSetup,
    list_action_modes,
    make_action_mode,
    register_action_mode,
)

__all__ = [
    "ACTION_MODES",
    "ANY_CONTROLLER",
    "RESIDUAL_SHARE",
    "SMOOTHING_TIME",
    "ActionField",
    "ActionModeSpec",
    "CommandInputs",
    "CommandedController",
    "ModeSetup",
    "ResidualController",
    "ResidualTorque",
    "list_action_modes",
    "make_action_mode",
    "register_action_mode",
]
