"""Single environments and the bare loops of MuJoCo steps under them, one core each."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from typing import Any

import gymnasium
import mujoco
import numpy as np

import prp_gym
from bench.rounds import CONTACT, FREE, REACHER, Contender, Effort, Label, timed
from prp_gym.robot.arrays import Array

ACTION_COUNT = 200  # that every contender repeats
ACTION_SHARE = 0.2  # of the actuator limits: moves the arm through its range without resting on the stops
FREQUENCIES = (500.0, 50.0)
"""[Hz] 2 and 20 substeps of 1 ms."""

PLACES = tuple((environment, frequency) for environment in (FREE, CONTACT) for frequency in FREQUENCIES)
"""Environments of this suite and their rates of control [Hz]."""

REACHER_FREQUENCY = 50.0
"""[Hz] Reacher-v5 takes 2 substeps of 10 ms."""

_STARTS = 16

Start = tuple[mujoco.MjModel, Array, Array]


@cache
def random_actions(num_envs: int, size: int) -> Array:
    """The same random actions for every contender of a size (k, num_envs, size)."""
    shape = (ACTION_COUNT, num_envs, size)
    return np.random.default_rng(0).uniform(-ACTION_SHARE, ACTION_SHARE, shape).astype(np.float32)


def keywords(label: Label, duration: float) -> dict[str, Any]:
    """Keywords of an environment: those of this suite run at a frequency, others know only their own."""
    if label.environment not in prp_gym.list_envs():
        return {}
    return {"control_frequency": label.control_frequency, "duration": duration}


def environment_loop(env: gymnasium.Env[Any, Any]) -> Callable[[], int]:
    """A chunk of steps of an environment, with resets."""
    actions = list(random_actions(1, env.action_space.shape[0])[:, 0])  # type: ignore[index]
    env.reset(seed=0)

    def chunk() -> int:
        for action in actions:
            _, _, terminated, truncated, _ = env.step(action)
            if terminated or truncated:
                env.reset()
        return ACTION_COUNT

    return chunk


def bare_loop(env: gymnasium.Env[Any, Any]) -> Callable[[], int]:
    """A chunk of bare `mj_step` calls on an environment's models, under the same torques.

    It starts anew as often as the environment does, from what the environment's resets drew: joint state and
    model, with the surface where there is one.

    Args:
        env: of this suite; it is only asked for models.
    """
    inner: Any = env.unwrapped
    starts = [_start(inner, seed) for seed in range(_STARTS)]
    torques = list(random_actions(1, inner.action_space.shape[0])[:, 0] * inner.torque_limit)
    data = mujoco.MjData(starts[0][0])
    substeps, horizon = inner.config.substeps, inner.config.horizon
    model, control, count = _begin(data, starts[0]), data.ctrl, 0

    def chunk() -> int:
        nonlocal model, count
        for torque in torques:
            control[:] = torque
            mujoco.mj_step(model, data, substeps)
            count += 1
            if count % horizon == 0:
                model = _begin(data, starts[count // horizon % _STARTS])
        return ACTION_COUNT

    return chunk


def _begin(data: mujoco.MjData, start: Start) -> mujoco.MjModel:
    """Put simulation data into an episode's start, and return that episode's model."""
    model, position, velocity = start
    mujoco.mj_resetData(model, data)
    data.qpos[:], data.qvel[:] = position, velocity
    return model


def _start(inner: Any, seed: int) -> Start:
    """Model, joint position and joint velocity of an episode's start."""
    inner.reset(seed=seed)
    physics = inner.physics
    return physics.model(), physics.joint_position[0].copy(), physics.joint_velocity[0].copy()


def both_clocks(label: Label, rate: Callable[[float], float]) -> Iterator[Contender]:
    """A contender that runs with and without MuJoCo's clock."""
    for clock in (True, False):
        yield Contender(replace(label, clock=clock), rate)


def contenders(effort: Effort) -> list[Contender]:
    """Bare loops, environments of this suite and Reacher-v5."""
    found: list[Contender] = []
    for place in PLACES:
        for kind, loop in (("bare", bare_loop), ("single", environment_loop)):
            label = Label(kind, *place)
            env = gymnasium.make(label.environment, **keywords(label, effort.duration))
            found += both_clocks(label, timed(loop(env)))
    reacher = timed(environment_loop(gymnasium.make(REACHER)))
    return [*both_clocks(Label("single", REACHER, REACHER_FREQUENCY), reacher), *found]
