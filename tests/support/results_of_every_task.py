"""Prints digests of the results of every task and controller, and the CPU features in use."""

import ctypes
import hashlib
import json
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np

import prp_gym
from prp_gym.tasks import SCENARIOS

STEPS = 12
NUM_ENVS = 2


def digest(arrays: Iterable[Any]) -> str:
    """The SHA-256 of arrays, one after the other."""
    whole = hashlib.sha256()
    for array in arrays:
        whole.update(np.ascontiguousarray(array).tobytes())
    return whole.hexdigest()


def random_episode(environment_id: str, scenario: str) -> list[Any]:
    """Observations and rewards under random actions."""
    env = gymnasium.make_vec(environment_id, num_envs=NUM_ENVS, scenario=scenario)
    rng = np.random.default_rng(1)
    found = [env.reset(seed=5)[0]]
    for _ in range(STEPS):
        action = rng.uniform(-0.5, 0.5, env.action_space.shape)
        found += env.step(action.astype(np.float32))[:2]
    return found


def controlled_episode(environment_id: str, scenario: str, name: str) -> list[Any]:
    """Observations, actions and rewards under a controller."""
    env = gymnasium.make_vec(environment_id, num_envs=NUM_ENVS, scenario=scenario)
    policy = prp_gym.make_baseline(name, env)
    observation, _ = env.reset(seed=6)
    found, state = [observation], None
    for _ in range(STEPS):
        action, state = policy.predict(observation, state)
        observation, reward, *_ = env.step(action)
        found += [action, observation, reward]
    return found


def all_digests() -> dict[str, str]:
    """The digest of every task under random actions and under every controller."""
    found = {}
    for index, environment_id in enumerate(prp_gym.list_envs()):
        layout = gymnasium.make(environment_id).unwrapped.observation_layout  # type: ignore[attr-defined]
        scenario = SCENARIOS[1 + index % 2]
        found[f"{environment_id} random"] = digest(random_episode(environment_id, scenario))
        for turn, name in enumerate(prp_gym.list_baselines(layout)):
            chosen = SCENARIOS[1 + (index + turn) % 2]
            found[f"{environment_id} {name}"] = digest(controlled_episode(environment_id, chosen, name))
    return found


def openblas_kernel() -> str:
    """The name of the kernels that NumPy's OpenBLAS uses; empty without OpenBLAS."""
    for library in sorted((Path(np.__file__).parent.parent / "numpy.libs").glob("*openblas*")):
        name = ctypes.CDLL(str(library)).scipy_openblas_get_corename64_
        name.restype = ctypes.c_char_p
        return str(name().decode())
    return ""


def dependent_on_the_cpu() -> dict[str, str]:
    """Digests of functions of NumPy that this package avoids, or uses for networks alone."""
    rng = np.random.default_rng(2)
    x, y, square = rng.normal(size=(20000, 3)), rng.normal(size=(20000, 3)), rng.normal(size=(64, 64))
    return {
        "vecdot": digest([np.vecdot(x, y)]),
        "matmul": digest([(square.astype(np.float32) @ square.astype(np.float32))]),
        "power": digest([np.abs(x) ** 3]),
    }


if __name__ == "__main__":
    extensions = np.show_config(mode="dicts")["SIMD Extensions"]
    report = {
        "kernel": openblas_kernel(),
        "extensions": extensions.get("found", []),
        "digests": all_digests(),
        "dependent": dependent_on_the_cpu(),
    }
    json.dump(report, sys.stdout)
