"""Episodes of many seeds that compiled code runs with the controller in it."""

import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from gymnasium.utils import seeding

from prp_gym.errors import CompilerError, UntraceableError
from prp_gym.evaluation.compiled_controller import CompiledController
from prp_gym.evaluation.recorder import Recorder
from prp_gym.evaluation.rollout import Policy, Rollout
from prp_gym.robot.arrays import Array
from prp_gym.symbolic.compiler import compiles_by_default
from prp_gym.tasks.setup import COMPILED

_TIMED = 16  # actions on which the compute time of a policy is measured


def runs_compiled(policy: Any, inner: Any) -> bool:
    """Whether compiled code can run a policy in an environment, if the formulas of both can be traced."""
    own = getattr(type(policy), "compiled", False) and "predict" not in vars(policy)
    if not own or not getattr(policy, "batched", False):
        return False
    fits = policy.interface.torque_limit.shape == inner.action_space.shape
    compiles = inner.config.engine == COMPILED or compiles_by_default()
    return bool(fits and compiles and inner.action_mode == "torque")


def record_compiled(policy: Policy, inner: Any, seeds: Sequence[int]) -> list[Rollout] | None:
    """Run one episode for each seed in compiled code, and record them; see `record_episodes`.

    Returns:
        the episodes; None where the policy or the environment is not one that compiled code can run, where
        there is no compiler for it, where an action was not finite, and with MuJoCo's physics also where the
        bits would differ from those of NumPy, or a simulation left its bounds.
    """
    if not runs_compiled(policy, inner):
        return None
    loop, _, observation = begin(inner.make_loop, seeds)
    recorder = Recorder(inner, loop)
    try:
        controller = CompiledController(policy, observation)
        if inner.config.engine != COMPILED and not controller.has_bits_of_numpy:
            return None
        record = loop.run_episodes(controller, observation)
    except (UntraceableError, CompilerError):
        return None
    if record is None:
        return None
    recorder.take_episodes(record)
    times = [time_one(policy, observation[0]) for _ in range(_TIMED)]
    return [recorder.rollout(row, int(seed), np.array(times)) for row, seed in enumerate(seeds)]


def begin(
    make_loop: Callable[[int], Any], seeds: Sequence[int]
) -> tuple[Any, list[np.random.Generator], Array]:
    """A loop in which an episode of each seed begins; its generators and its observations.

    Args:
        make_loop: function that gives a loop of so many environments.
        seeds: seeds of the episodes (N).
    """
    rngs = [seeding.np_random(int(seed))[0] for seed in seeds]
    loop = make_loop(len(seeds))
    return loop, rngs, loop.reset(np.arange(len(seeds)), rngs, {})


def time_one(policy: Policy, observation: Array) -> float:
    """How long a policy takes for the first action of one environment [s]."""
    before = time.perf_counter()
    policy.predict(observation, None, episode_start=np.array([True]), deterministic=True)
    return time.perf_counter() - before
