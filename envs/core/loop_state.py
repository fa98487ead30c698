"""The complete state of an episode loop."""

from typing import Any, NamedTuple

from prp_gym.physics.abstract_simulation import PhysicsState

STATE = (
    *("task", "ground_truth", "commanded_torque", "_actuators", "_sensors", "_window"),
    *("_needs_reset", "_all_ready"),
)
"""Attributes that make up the state of every loop, beside the state of its physics."""


class LoopState(NamedTuple):
    """The complete state of a loop."""

    physics: PhysicsState
    rest: dict[str, Any]
