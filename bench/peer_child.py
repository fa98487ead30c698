"""Steps per second of a peer's environment, in that peer's own virtual environment.

It replies to lines of JSON with lines of JSON (see `bench.process`), and imports only Gymnasium, NumPy and
the peer.
"""

import contextlib
import ctypes
import importlib
import json
import sys
import time
from importlib.metadata import version
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np

ACTION_SHARE = 0.2  # as for all other programs
_CHUNK = 20


def stop_clock() -> None:
    """Turn off the clock of MuJoCo's steps."""
    import mujoco

    for path in sorted(Path(mujoco.__file__).parent.glob("libmujoco*")):
        with contextlib.suppress(OSError, ValueError):
            ctypes.c_void_p.in_dll(ctypes.CDLL(str(path)), "mjcb_time").value = None


def steps_per_second(env: Any, actions: Any, seconds: float) -> float:
    """Steps per second over about the given time, with resets."""
    steps, start = 0, time.perf_counter()
    while (elapsed := time.perf_counter() - start) < seconds:
        for action in actions[steps % len(actions) :][:_CHUNK]:
            _, _, terminated, truncated, _ = env.step(action)
            steps += 1
            if terminated or truncated:
                env.reset()
    return steps / elapsed


def main() -> None:
    """`python peer_child.py MODULE ID CLOCK PACKAGE...`: print the packages' versions, then measure."""
    module, environment, clock, *packages = sys.argv[1:]
    answers, sys.stdout = sys.stdout, sys.stderr  # output of the libraries is not a reply
    gymnasium.register_envs(importlib.import_module(module))
    env = gymnasium.make(environment)
    shape = (10 * _CHUNK, *env.action_space.shape)  # type: ignore[misc]
    actions = np.random.default_rng(0).uniform(-ACTION_SHARE, ACTION_SHARE, shape).astype(np.float32)
    env.reset(seed=0)
    if clock == "stopped":
        stop_clock()
    print(json.dumps({name: version(name) for name in packages}), file=answers, flush=True)
    for line in sys.stdin:
        rate = steps_per_second(env, actions, json.loads(line)["seconds"])
        print(json.dumps({"steps_per_second": rate}), file=answers, flush=True)


if __name__ == "__main__":
    main()
