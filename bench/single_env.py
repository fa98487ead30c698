"""Speed of the single environment: `make bench`.

In one run and in turn, so that a machine whose speed drifts does not favour one of them: a bare loop of
MuJoCo steps of the same model under the same torques, our environment, and Gymnasium's Reacher-v5.
"""

import os
import platform
import time
from collections.abc import Callable
from typing import Any

import gymnasium
import mujoco
import numpy as np
from rich.console import Console
from rich.table import Table

import prp_gym
from prp_gym.physics import to_mjcf
from prp_gym.robot import NOMINAL
from prp_gym.robot.arrays import Array

ROUNDS = 9
SECONDS_PER_ROUND = 0.4
ENVIRONMENT = "PRP-JointTracking-v0"
ACTION_SHARE = 0.2  # of the actuator limits: moves the arm through its range without resting on the stops
_CHUNK = 200
_STARTS = 64


def random_actions(size: int) -> Array:
    """The same random actions for every contender (k, size)."""
    return np.random.default_rng(0).uniform(-ACTION_SHARE, ACTION_SHARE, (_CHUNK, size)).astype(np.float32)


def environment_loop(env: gymnasium.Env[Any, Any]) -> Callable[[], None]:
    """A chunk of steps of an environment, with resets."""
    actions = list(random_actions(env.action_space.shape[0]))  # type: ignore[index]
    env.reset(seed=0)

    def chunk() -> None:
        for action in actions:
            _, _, terminated, truncated, _ = env.step(action)
            if terminated or truncated:
                env.reset()

    return chunk


def bare_loop(substeps: int, horizon: int) -> Callable[[], None]:
    """A chunk of bare `mj_step` calls on the environment's model, under the same torques and limits.

    It starts anew as often as the environment, from positions drawn as the environment draws them.
    """
    model = mujoco.MjModel.from_xml_string(to_mjcf())
    data = mujoco.MjData(model)
    torques = list(random_actions(3) * NOMINAL.torque_limit)
    control, count = data.ctrl, 0
    env = gymnasium.make(ENVIRONMENT)
    starts = [env.reset(seed=seed)[0][:3] for seed in range(_STARTS)]
    data.qpos[:] = starts[0]

    def chunk() -> None:
        nonlocal count
        for torque in torques:
            control[:] = torque
            mujoco.mj_step(model, data, substeps)
            count += 1
            if count % horizon == 0:
                mujoco.mj_resetData(model, data)
                data.qpos[:] = starts[count // horizon % _STARTS]

    return chunk


def steps_per_second(chunk: Callable[[], None]) -> float:
    """Steps a second over one round."""
    chunks, start = 0, time.perf_counter()
    while (elapsed := time.perf_counter() - start) < SECONDS_PER_ROUND:
        chunk()
        chunks += 1
    return chunks * _CHUNK / elapsed


def measure(contenders: dict[str, Callable[[], None]]) -> dict[str, Array]:
    """Steps a second of every contender in every round (ROUNDS), in turn."""
    rates: dict[str, list[float]] = {name: [] for name in contenders}
    for _ in range(ROUNDS):
        for name, chunk in contenders.items():
            rates[name].append(steps_per_second(chunk))
    return {name: np.array(values) for name, values in rates.items()}


def main() -> None:
    """Measure and print."""
    console = Console(width=120)
    versions = (
        f"prp_gym {prp_gym.__version__}, gymnasium {gymnasium.__version__}, mujoco {mujoco.__version__}"
    )
    console.print(
        f"{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}, {versions}"
    )
    contenders = {
        "Gymnasium Reacher-v5 (2 substeps)": environment_loop(gymnasium.make("Reacher-v5")),
        "bare mj_step, 2 substeps": bare_loop(2, 2500),
        "prp_gym at 500 Hz (2 substeps)": environment_loop(gymnasium.make(ENVIRONMENT)),
        "bare mj_step, 20 substeps": bare_loop(20, 250),
        "prp_gym at 50 Hz (20 substeps)": environment_loop(gymnasium.make(ENVIRONMENT, control_frequency=50)),
    }
    rates = measure(contenders)
    table = Table(title="steps a second, one core", title_justify="left")
    for header in ("loop", "median", "lowest", "highest"):
        table.add_column(header, justify="left" if header == "loop" else "right")
    for name, values in rates.items():
        numbers = (np.median(values), values.min(), values.max())
        table.add_row(name, *(f"{number:,.0f}" for number in numbers))
    console.print(table)
    reacher, bare_2, ours_500, bare_20, ours_50 = rates.values()
    for label, ratio in (
        ("500 Hz against Reacher-v5", ours_500 / reacher),
        ("500 Hz against the bare loop", ours_500 / bare_2),
        ("50 Hz against the bare loop", ours_50 / bare_20),
    ):
        console.print(f"ratio, median of the rounds: {label}: {np.median(ratio):.2f}", highlight=False)


if __name__ == "__main__":
    main()
