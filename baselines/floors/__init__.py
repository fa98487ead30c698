"""Floors: policies that do not attempt a task, whose scores every controller has to exceed.

They stand in every table of `evaluate` and `compare`, are not ranked with the controllers, and are no
controllers themselves: nothing is tuned, and no action mode drives them.
"""

from prp_gym.baselines.base.spec import ControllerSpec
from prp_gym.baselines.floors.hold import HOLD
from prp_gym.baselines.floors.zero_torque import ZERO_TORQUE

FLOORS: dict[str, ControllerSpec] = {spec.name: spec for spec in (ZERO_TORQUE, HOLD)}
"""The declared floors by name; `FLOORS[name].make(env)` is the policy for an environment."""

__all__ = ["FLOORS", "HOLD", "ZERO_TORQUE"]
