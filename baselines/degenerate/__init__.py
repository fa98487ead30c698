"""Degenerate policies: ways to exploit a reward without doing what a task asks, as rows of its audit."""

from prp_gym.baselines.base.spec import ControllerSpec
from prp_gym.baselines.degenerate.hover import HOVER
from prp_gym.baselines.degenerate.maximum_torque import MAXIMUM_TORQUE
from prp_gym.baselines.degenerate.press_the_stop import PRESS_THE_STOP

DEGENERATE: dict[str, ControllerSpec] = {spec.name: spec for spec in (HOVER, PRESS_THE_STOP, MAXIMUM_TORQUE)}
"""The declared degenerate policies by name."""

__all__ = ["DEGENERATE", "HOVER", "MAXIMUM_TORQUE", "PRESS_THE_STOP"]
