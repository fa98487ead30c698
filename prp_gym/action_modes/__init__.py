"""What actions mean beside torques: inner laws that an agent steers. Here laws and environments meet."""

from prp_gym.action_modes.catalogue import RESIDUAL_SHARE, ModeEntry, list_action_modes, make_action_mode

__all__ = ["RESIDUAL_SHARE", "ModeEntry", "list_action_modes", "make_action_mode"]
