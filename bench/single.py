"""Single environments, and bare loops of MuJoCo steps on the same models, each on one core."""

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

ACTION_COUNT = 200  # actions that every program repeats
ACTION_SHARE = (
    0.2  # share of the actuator limits: the arm moves through its range without resting at the stops
)
FREQUENCIES = (500.0, 50.0)
"""Control frequencies [Hz], with 2 and 20 substeps of 1 ms."""

CONDITIONS = tuple((environment, frequency) for environment in (FREE, CONTACT) for frequency in FREQUENCIES)
"""Environments of this suite and their control frequencies [Hz]."""

REACHER_FREQUENCY = 50.0
"""Control frequency of Reacher-v5 [Hz], which takes 2 substeps of 10 ms."""

_STARTS = 16

Start = tuple[mujoco.MjModel, Array, Array]


@cache
def random_actions(num_envs: int, size: int) -> Array:
    """Random actions (k, num_envs, size), the same for every program of a size."""
    shape = (ACTION_COUNT, num_envs, size)
    return np.random.default_rng(0).uniform(-ACTION_SHARE, ACTION_SHARE, shape).astype(np.float32)


def keywords(label: Label, duration: float) -> dict[str, Any]:
    """Keywords of an environment: those of this suite have a chosen frequency, others a fixed one."""
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

    It restarts as often as the environment, from states that its resets sampled: joint state and model, with
    the surface if there is one.

    Args:
        env: Environment of this suite, of which only the models are used.
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
    """Set simulation data to the start of an episode, and return the model of that episode."""
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
    """A program that is measured with and without MuJoCo's clock."""
    for clock in (True, False):
        yield Contender(replace(label, clock=clock), rate)


def contenders(effort: Effort) -> list[Contender]:
    """Bare loops, environments of this suite and Reacher-v5."""
    found: list[Contender] = []
    for condition in CONDITIONS:
        for kind, loop in (("bare", bare_loop), ("single", environment_loop)):
            label = Label(kind, *condition)
            env = gymnasium.make(label.environment, **keywords(label, effort.duration))
            found += both_clocks(label, timed(loop(env)))
    reacher = timed(environment_loop(gymnasium.make(REACHER)))
    return [*both_clocks(Label("single", REACHER, REACHER_FREQUENCY), reacher), *found]
