"""Short episodes, in which the compiled code of a task, its controllers and its action modes is loaded."""

from collections.abc import Iterator
from contextlib import closing, contextmanager, suppress
from typing import Any

import gymnasium
import numpy as np

from prp_gym.baselines import BASELINES, make_baseline
from prp_gym.baselines.base.gains import gain_sets
from prp_gym.baselines.floors import FLOORS
from prp_gym.envs.action_mode import TORQUE, list_action_modes
from prp_gym.errors import ShapeError
from prp_gym.evaluation import evaluate
from prp_gym.tasks.setup import COMPILED, MUJOCO

_FREQUENCY = 1000.0  # Hz, at which all gain sets are stable; the code is that of any control frequency
_DURATION = 0.01  # s
_ACTION_FREQUENCY = 100.0  # Hz, of action modes
_STEPS = 2  # of an action mode, the first of which NumPy computes


def run_short_episodes(environment_id: str, scenario: str) -> None:
    """Run everything that is compiled for a task in one scenario.

    Args:
        environment_id: id of the environment.
        scenario: scenario of the environment.

    Raises:
        CompilerError: no compiler, or one that does not work.
        GeneratedCodeError: generated code that the compiler rejects.
        PRPError: a controller that fails.
    """
    with _environment(environment_id, scenario, MUJOCO) as env:
        env.reset(seed=0)
    with _environment(environment_id, scenario, COMPILED) as env:
        layout = env.get_wrapper_attr("observation_layout")
        for controller in _controllers(env, layout):
            evaluate(controller, env, episodes=1)
    for mode in list_action_modes(layout):
        if mode != TORQUE:
            _run_mode(environment_id, scenario, mode)


def _controllers(env: gymnasium.Env[Any, Any], layout: Any) -> Iterator[Any]:
    """Every controller that runs on an environment, with each of its gain sets, and the floors."""
    for name, declared in BASELINES.items():
        if not declared.missing_fields(layout):
            for gains in gain_sets(name):
                with suppress(ShapeError):  # gains of the arm, on the link
                    yield make_baseline(name, env, gains=gains)
    yield from (floor.make(env) for floor in FLOORS.values())


def _run_mode(environment_id: str, scenario: str, mode: str) -> None:
    """Steps of an action mode."""
    keywords: dict[str, Any] = {"action_mode": mode, "control_frequency": _ACTION_FREQUENCY, "duration": 1.0}
    made = gymnasium.make(environment_id, scenario=scenario, engine=COMPILED, **keywords)
    with closing(made) as env:
        env.reset(seed=0)
        for _ in range(_STEPS):
            env.step(np.zeros(env.action_space.shape, dtype=np.float32))


@contextmanager
def _environment(environment_id: str, scenario: str, engine: str) -> Iterator[gymnasium.Env[Any, Any]]:
    """An environment whose actions are torques, with short episodes."""
    keywords: dict[str, Any] = {"control_frequency": _FREQUENCY, "duration": _DURATION}
    with closing(gymnasium.make(environment_id, scenario=scenario, engine=engine, **keywords)) as env:
        yield env
