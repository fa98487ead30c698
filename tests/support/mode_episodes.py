"""What the tests of the action modes share: every mode on an environment that can have it."""

from collections.abc import Hashable
from functools import cache
from typing import Any

import gymnasium
import numpy as np

import prp_gym
from prp_gym.action_modes import ACTION_MODES, list_action_modes
from prp_gym.baselines import make_baseline
from prp_gym.envs import PRPEnv
from prp_gym.envs.action_mode import TORQUE
from prp_gym.robot.arrays import Array
from tests.support.covering import covering, one_of_each

RESIDUAL = "residual:"


def made(environment_id: str, mode: str = TORQUE, **keywords: Any) -> PRPEnv:
    env = gymnasium.make(environment_id, action_mode=mode, **keywords).unwrapped
    assert isinstance(env, PRPEnv)
    return env


@cache
def environment(environment_id: str) -> PRPEnv:
    """A shared environment that callers inspect but never step."""
    return made(environment_id)


@cache
def modes_of(environment_id: str) -> tuple[str, ...]:
    """The modes beside `torque` that an environment can have."""
    names = list_action_modes(environment(environment_id).observation_layout)
    return tuple(name for name in names if name != TORQUE)


def controller_of(mode: str) -> str:
    """The controller that a mode runs."""
    return mode.removeprefix(RESIDUAL) if mode.startswith(RESIDUAL) else ACTION_MODES[mode].entry.controller


def kind_of(combination: tuple[str, str]) -> Hashable:
    """What an action means and to which model: the arm's or the link's."""
    environment_id, mode = combination
    return mode, type(environment(environment_id).arm)


def way_of(combination: tuple[str, str]) -> Hashable:
    """How an action acts: through inputs of a controller, or as a residual of a stateful one or not."""
    environment_id, mode = combination
    if not mode.startswith(RESIDUAL):
        return kind_of(combination)
    env = environment(environment_id)
    policy = make_baseline(controller_of(mode), env)
    stateful = policy.predict(np.zeros(env.observation_layout.size))[1] is not None
    return stateful, type(env.arm)


COMBINATIONS = [(name, mode) for name in prp_gym.list_envs() for mode in modes_of(name)]
"""All environments in all modes that they can have."""

COVERING = covering(COMBINATIONS, kind_of)
"""Every mode once on the arm and on the link where it can run there, and every environment."""

KINDS = one_of_each(COMBINATIONS, way_of)
"""Every way in which an action acts, stateless and stateful controllers, on the arm and on the link."""


def random_actions(env: Any, count: int, seed: int = 1, share: float = 1.0) -> Array:
    """(count, *shape of an action), as float32 as agents give them, some beyond ±1 for a share above 1."""
    rng = np.random.default_rng(seed)
    return rng.uniform(-share, share, (count, *env.action_space.shape)).astype(np.float32)
