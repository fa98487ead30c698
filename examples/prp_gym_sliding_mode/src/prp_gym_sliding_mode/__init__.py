"""A sliding-mode controller and a task for prp_gym, declared as its module is imported."""

from prp_gym_sliding_mode.joint_round_trip import TASK
from prp_gym_sliding_mode.sliding_mode import CONTROLLER, SlidingModeController, SlidingModeSettings

__all__ = ["CONTROLLER", "TASK", "SlidingModeController", "SlidingModeSettings"]
