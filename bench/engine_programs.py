"""The programs of `make bench-engines`, each of which runs in a process of its own."""

import os
import time
from collections.abc import Callable, Mapping
from contextlib import nullcontext
from dataclasses import dataclass
from typing import Any, NamedTuple

import gymnasium

from bench.engine_training import Training
from bench.rounds import CONTACT, FREE
from bench.single import bare_loop, environment_loop, random_actions
from prp_gym.baselines import CONTROLLERS, list_baselines, make_baseline
from prp_gym.evaluation import evaluate
from prp_gym.gradients.score_gradient import score_gradient
from prp_gym.physics.clock import clock_reading
from prp_gym.tasks.setup import MUJOCO
from prp_gym.tuning.episodes import Episodes

FORCE = "PRP-Force-v0"
SIZE = 1024
"""Number of environments of the vector environments."""


@dataclass(frozen=True)
class Program:
    """What a process measures.

    Attributes:
        kind: `single`, `reset`, `vector`, `bare`, `evaluate`, `held`, `gradient`, `scores` or `training`.
        environment: environment id.
        engine: engine of the environment; empty for one of another suite.
        scenario: scenario; empty for an environment of another suite.
        without_clock: whether MuJoCo's clock is stopped where another suite would read it.
        with_numpy: whether NumPy computes all but the physics, as on a machine without compiled code.
        all_cores: whether all cores are used, and time is that of a clock instead of the processor.
    """

    kind: str
    environment: str
    engine: str = MUJOCO
    scenario: str = "randomized"
    without_clock: bool = False
    with_numpy: bool = False
    all_cores: bool = False


class Measured(NamedTuple):
    """What a program has measured.

    Attributes:
        rate: number of steps, resets or episodes per second.
        shares: shares of parts in the time; empty unless the program is a training.
    """

    rate: float
    shares: Mapping[str, float]


def _keywords(program: Program) -> dict[str, Any]:
    return {"scenario": program.scenario, "engine": program.engine} if program.engine else {}


def _single(program: Program) -> Callable[[], float]:
    """Steps of one environment, with resets."""
    return environment_loop(gymnasium.make(program.environment, **_keywords(program)))


def _reset(program: Program) -> Callable[[], float]:
    """Resets of one environment."""
    env = gymnasium.make(program.environment, **_keywords(program))
    env.reset(seed=0)

    def chunk() -> float:
        for _ in range(20):
            env.reset()
        return 20.0

    return chunk


def _vector(program: Program, size: int = SIZE, **more: Any) -> Callable[[], float]:
    """Steps of N environments."""
    threads = 0 if program.all_cores else 1
    more |= _keywords(program)
    env = gymnasium.make_vec(program.environment, num_envs=size, num_threads=threads, **more)
    actions = list(random_actions(size, (env.single_action_space.shape or ())[0]))[:8]
    env.reset(seed=0)

    def chunk() -> float:
        for action in actions:
            env.step(action)
        return len(actions) * size

    return chunk


_HELD_MODE = {FREE: "joint_inverse_dynamics", CONTACT: "admittance", FORCE: "variable_force_position"}


def _held(program: Program) -> Callable[[], float]:
    """Steps of an action mode at 20 Hz, N = 8."""
    mode = _HELD_MODE[program.environment]
    return _vector(program, 8, action_mode=mode, control_frequency=20.0)


_CONTROLLERS = {FREE: "joint_inverse_dynamics", CONTACT: "impedance", FORCE: "force_inner_position"}
_SEEDS = range(64)  # of episodes of 500 periods


def _short(program: Program) -> tuple[Any, Any]:
    """An environment with episodes of 1 s, and a controller for it."""
    env = gymnasium.make(program.environment, duration=1.0, **_keywords(program))
    return env, make_baseline(_CONTROLLERS[program.environment], env)


def _gradient(program: Program) -> Callable[[], float]:
    """Episodes with the derivatives of their scores by all settings of a controller."""
    env, controller = _short(program)

    def chunk() -> float:
        return len(score_gradient(env, controller, _SEEDS).scores)

    return chunk


def _scores(program: Program) -> Callable[[], float]:
    """The same episodes without derivatives."""
    env, controller = _short(program)
    episodes = Episodes(env, _SEEDS)

    def chunk() -> float:
        return len(episodes.run(controller).scores)

    return chunk


def _bare(program: Program) -> Callable[[], float]:
    """Bare `mj_step` calls on the same models."""
    return bare_loop(gymnasium.make(program.environment, scenario=program.scenario))


def _evaluate(program: Program) -> Callable[[], float]:
    """Episodes of all controllers of a task that can be traced, with all metrics."""
    env = gymnasium.make(program.environment, **_keywords(program))
    layout = env.get_wrapper_attr("observation_layout")
    names = [name for name in list_baselines(layout) if CONTROLLERS.find(name).policy.compiled]
    policies = [make_baseline(name, env) for name in names]

    def chunk() -> float:
        for policy in policies:
            if not evaluate(policy, env, 20, seed=0).metrics:
                raise AssertionError
        return 20 * len(policies)

    return chunk


def _training(program: Program) -> Training:
    """Rollouts and updates of PPO in contact."""
    return Training(program.environment, program.engine)


_KINDS: dict[str, Callable[[Program], Callable[[], float]]] = {
    "single": _single,
    "reset": _reset,
    "vector": _vector,
    "held": _held,
    "bare": _bare,
    "evaluate": _evaluate,
    "gradient": _gradient,
    "scores": _scores,
    "training": _training,
}


def measure(program: Program, seconds: float) -> Measured:
    """Run a program in this process.

    Args:
        program: what is measured.
        seconds: least time, of the processor, or of a clock with all cores [s].
    """
    now = time.perf_counter if program.all_cores else time.process_time
    with clock_reading(False) if program.without_clock else nullcontext():
        chunk = _KINDS[program.kind](program)
        if not program.with_numpy:
            chunk()
        done, start = 0.0, now()
        while (elapsed := now() - start) < seconds:
            done += chunk()
    return Measured(done / elapsed, chunk.shares if isinstance(chunk, Training) else {})


def surroundings(program: Program) -> dict[str, str]:
    """Variables of the environment of a program's process."""
    turned_off = {"PRP_GYM_COMPILED": "0"} if program.with_numpy else {}
    return {**os.environ, "OMP_NUM_THREADS": "1", **turned_off}
