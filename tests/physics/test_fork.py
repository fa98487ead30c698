"""A forked process goes on with its parent's simulations, although it does not have their threads."""

import gc
import hashlib
import multiprocessing
import signal
import warnings
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any

import gymnasium
import numpy as np
import pytest

import prp_gym  # noqa: F401

STEPS, LIMIT = 30, 60
"""Steps, and seconds after which a forked process that hangs is ended."""


def digest_of_steps(env: gymnasium.vector.VectorEnv[Any, Any, Any]) -> str:
    found = hashlib.sha256()
    for _ in range(STEPS):
        observation, reward, *_ = env.step(np.full(env.action_space.shape or (), 0.3))
        found.update(observation.tobytes() + reward.tobytes())
    return found.hexdigest()


def reset(env: gymnasium.vector.VectorEnv[Any, Any, Any]) -> str:
    env.reset(seed=3)
    return digest_of_steps(env)


def in_a_forked_process(work: Callable[[], str]) -> str:
    """What some work returns in a forked process; empty where it hangs."""
    context = multiprocessing.get_context("fork")
    receiver, sender = context.Pipe(duplex=False)

    def run(pipe: Connection) -> None:
        signal.alarm(LIMIT)
        pipe.send(work())

    process = context.Process(target=run, args=(sender,))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # of Python 3.12: the parent has threads
        process.start()
    process.join()
    return str(receiver.recv()) if receiver.poll() else ""


@pytest.mark.parametrize("environment_id", ["PRP-Force-v0", "PRP-Adaptive-v0"])
@pytest.mark.parametrize("num_envs", [3, 130])  # with a data structure for each simulation, and without
@pytest.mark.parametrize("work", [digest_of_steps, reset])
def test_forked_process_goes_on_bit_for_bit_as_its_parent(
    environment_id: str, num_envs: int, work: Callable[[Any], str]
) -> None:
    env = gymnasium.make_vec(environment_id, num_envs, num_threads=2, scenario="realistic")
    env.reset(seed=0)
    digest_of_steps(env)
    found = in_a_forked_process(lambda: work(env))
    assert found == in_a_forked_process(lambda: in_a_forked_process(lambda: work(env)))
    assert found == work(env)
    env.close()


def test_forked_process_that_does_not_use_the_simulations_can_drop_them() -> None:
    environments = [gymnasium.make_vec("PRP-Adaptive-v0", 3, num_threads=2)]

    def drop() -> str:
        environments.clear()
        gc.collect()
        return "dropped"

    assert in_a_forked_process(drop) == "dropped"
    environments.clear()
