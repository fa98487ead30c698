"""What the tests of the action modes share: every mode on an environment that can have it."""

from functools import cache
from typing import Any

import gymnasium
import numpy as np

import prp_gym
from prp_gym.action_modes import ACTION_MODES, list_action_modes
from prp_gym.envs import PRPEnv
from prp_gym.envs.action_mode import TORQUE
from prp_gym.robot.arrays import Array

RESIDUAL = "residual:"

# one for every kind of world and reference: pose with force, joints, one link; and random draws of all
_PLACES = (
    "PRP-ForcePosition-v0",
    "PRP-Impedance-v0",
    "PRP-JointTracking-v0",
    "PRP-PoseTracking-v0",
    "PRP-Adaptive-v0",
)


def made(environment_id: str, mode: str = TORQUE, **keywords: Any) -> PRPEnv:
    env = gymnasium.make(environment_id, action_mode=mode, **keywords).unwrapped
    assert isinstance(env, PRPEnv)
    return env


@cache
def modes_of(environment_id: str) -> tuple[str, ...]:
    """The modes beside `torque` that an environment can have."""
    names = list_action_modes(made(environment_id).observation_layout)
    return tuple(name for name in names if name != TORQUE)


def law_of(mode: str) -> str:
    """The controller that a mode runs."""
    return mode.removeprefix(RESIDUAL) if mode.startswith(RESIDUAL) else ACTION_MODES[mode].entry.controller


def _one_place_each() -> list[tuple[str, str]]:
    """Every mode on the first place that can have it."""
    return [
        (next(place for place in _PLACES if mode in modes_of(place)), mode)
        for mode in list_action_modes()
        if mode != TORQUE
    ]


PAIRS = [(name, mode) for name in prp_gym.list_envs() for mode in modes_of(name)]
"""All environments in all modes that they can have."""

PLACES = _one_place_each()
"""Every mode once."""

KINDS = [(name, mode) for name, mode in PLACES if not mode.startswith(RESIDUAL)] + [
    ("PRP-Adaptive-v0", "joint_position"),
    ("PRP-Adaptive-v0", "residual:adaptive"),
    ("PRP-ForcePosition-v0", "residual:force_inner_position"),
]
"""Every way in which an action steers, and laws that remember."""


def random_actions(env: Any, count: int, seed: int = 1, share: float = 1.0) -> Array:
    """(count, *shape of an action), as float32 as agents give them, some beyond ±1 for a share above 1."""
    rng = np.random.default_rng(seed)
    return rng.uniform(-share, share, (count, *env.action_space.shape)).astype(np.float32)
