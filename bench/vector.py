"""Vector environments of size N: native, Gymnasium's and Stable-Baselines3's, in free space and in contact.

Small native vector environments and Stable-Baselines3's adapter run whole episodes, which start and end
together. For others that would take too long: before the measurement their episodes are spread evenly over
their length, by restarting one group of environments after the other, so that every moment contains its share
of all phases of an episode and of resets. For loops over single environments this makes no difference; the
native one is faster when it resets many environments together.

A Gymnasium vector environment uses one call per episode for its restart, which is not counted as a step.
"""

import itertools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import AsyncVectorEnv, VectorEnv
from numpy.typing import NDArray
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.vec_env import VecEnv

import prp_gym
from bench import cores
from bench.rounds import ALL_CORES, CONTACT, FREE, REACHER, Contender, Effort, Label, timed
from bench.single import FREQUENCIES, REACHER_FREQUENCY, both_clocks, keywords, random_actions
from prp_gym.physics.clock import read_clock

_PERIODS_BETWEEN_RESTARTS = 5
_ONE_THREAD = (64, 1024)
_WHOLE_UP_TO = 8  # environments; larger numbers take too long
_LONG = (CONTACT, 500.0)  # spreading its largest sizes would take minutes


@dataclass(frozen=True)
class Pack:
    """N environments that are stepped together, with their resets.

    Attributes:
        step: Function that takes actions (N, joints).
        restart: Function that restarts the environments of a mask (N).
        horizon: Number of steps of an episode.
        calls: Number of calls of `step` per episode.
        joints: Number of components of an action.
        close: Function that ends the environments.
    """

    step: Callable[[Any], object]
    restart: Callable[[NDArray[np.bool_]], object]
    horizon: int
    calls: int
    joints: int
    close: Callable[[], None]


def gymnasium_pack(env: VectorEnv[Any, Any, Any], horizon: int) -> Pack:
    """A vector environment with Gymnasium's interface, reset in the step after the end of an episode."""
    env.reset(seed=0)
    joints = env.single_action_space.shape[0]  # type: ignore[index]

    def restart(mask: NDArray[np.bool_]) -> object:
        return env.reset(options={"reset_mask": mask})

    return Pack(env.step, restart, horizon, horizon + 1, joints, env.close)


def library_pack(env: VecEnv, horizon: int) -> Pack:
    """A vector environment with Stable-Baselines3's interface, reset in the step that ends an episode."""
    env.seed(0)
    env.reset()
    singles = getattr(env, "envs", ())

    def restart(mask: NDArray[np.bool_]) -> None:
        for index in np.flatnonzero(mask):
            singles[index].reset()

    return Pack(env.step, restart, horizon, horizon, env.action_space.shape[0], env.close)  # type: ignore[index]


def make_pack(label: Label, duration: float) -> Pack:
    """The environments of a label."""
    name, count, settings = label.environment, label.num_envs, keywords(label, duration)
    horizon = round(label.control_frequency * duration) if settings else _own_horizon(name)
    if label.kind == "dummy":
        return library_pack(make_vec_env(name, count, env_kwargs=settings), horizon)
    if label.kind == "adapter":
        adapter: VecEnv = prp_gym.make_sb3_vec_env(name, count, num_threads=label.threads, **settings)
        return library_pack(adapter, horizon)
    if label.kind == "native":
        native = gymnasium.make_vec(name, num_envs=count, num_threads=label.threads, **settings)
        return gymnasium_pack(native, horizon)
    if label.kind == "async":
        return gymnasium_pack(AsyncVectorEnv([partial(_in_worker, label, settings)] * count), horizon)
    return gymnasium_pack(gymnasium.make_vec(name, count, vectorization_mode="sync", **settings), horizon)


def _own_horizon(name: str) -> int:
    return gymnasium.spec(name).max_episode_steps or 1


def _in_worker(label: Label, settings: dict[str, Any]) -> gymnasium.Env[Any, Any]:
    """An environment in a process with or without MuJoCo's clock."""
    env = gymnasium.make(label.environment, **settings)
    read_clock(label.clock)
    return env


def stagger(pack: Pack, actions: Sequence[Any]) -> None:
    """Spread the environments evenly over an episode's length."""
    count = len(actions[0])
    groups = max(1, min(count, pack.horizon // _PERIODS_BETWEEN_RESTARTS))
    of_group, turn = np.arange(count) % groups, itertools.cycle(actions)
    for group in range(groups):
        pack.restart(of_group == group)
        for _ in range(pack.horizon // groups):
            pack.step(next(turn))


def runs_whole_episodes(label: Label) -> bool:
    """Whether a chunk is one episode of all environments, as users of this suite run it."""
    return label.kind == "adapter" or (label.kind == "native" and label.num_envs <= _WHOLE_UP_TO)


def step_loop(
    label: Label, duration: float, chunk_steps: int
) -> tuple[Callable[[], float], Callable[[], None]]:
    """Function that runs a chunk of steps and returns their number, and one that ends the environments."""
    pack = make_pack(label, duration)
    actions = list(random_actions(label.num_envs, pack.joints))
    turn = itertools.cycle(actions)
    calls = pack.calls
    if not runs_whole_episodes(label):
        stagger(pack, actions)
        calls = max(1, chunk_steps // label.num_envs)
    steps = calls * label.num_envs * pack.horizon / pack.calls

    def chunk() -> float:
        for _ in range(calls):
            pack.step(next(turn))
        return steps

    return chunk, pack.close


def contender(label: Label, effort: Effort) -> list[Contender]:
    """A vector environment, with and without MuJoCo's clock."""
    if label.kind == "async":  # the clock setting is that of the worker processes
        return [_contender(replace(label, clock=clock), effort) for clock in (True, False)]
    chunk, close = step_loop(label, effort.duration, effort.chunk_steps)
    first, second = both_clocks(label, timed(chunk))
    return [first, replace(second, close=close)]


def _contender(label: Label, effort: Effort) -> Contender:
    chunk, close = step_loop(label, effort.duration, effort.chunk_steps)
    return Contender(label, timed(chunk), close)


def labels(effort: Effort) -> Iterator[Label]:
    """Labels of all vector environments; those with worker processes come first, before threads exist."""
    least = min(effort.loop_sizes)
    yield Label("async", REACHER, REACHER_FREQUENCY, least)
    yield from (Label("async", FREE, frequency, least) for frequency in FREQUENCIES)
    for count in effort.loop_sizes:
        yield Label("sync", REACHER, REACHER_FREQUENCY, count)
    yield Label("dummy", REACHER, REACHER_FREQUENCY, effort.library_size)
    for frequency in FREQUENCIES:
        yield Label("dummy", FREE, frequency, effort.library_size)
        yield Label("adapter", FREE, frequency, effort.library_size, ALL_CORES)
        for environment in (FREE, CONTACT):
            long = (environment, frequency) == _LONG
            for count in effort.loop_sizes[: 1 if long else None]:
                yield Label("sync", environment, frequency, count)
            for count in effort.sizes[: -1 if long else None]:
                yield Label("native", environment, frequency, count, ALL_CORES)
                if count in _ONE_THREAD:
                    yield Label("native", environment, frequency, count, 1)


def contenders(effort: Effort) -> list[Contender]:
    """Vector environments, and the bare loops on all cores."""
    found = [one for label in labels(effort) for one in contender(label, effort)]
    return [*found, *cores.contenders(effort)]
