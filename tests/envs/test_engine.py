"""The compiled engine as a keyword: every task, scenario and action mode gives what MuJoCo gives."""

import itertools
import pickle
from contextlib import closing
from typing import Any

import gymnasium
import numpy as np
import pytest

import prp_gym
from prp_gym.baselines import CONTROLLERS, make_baseline
from prp_gym.envs.action_mode import list_action_modes
from prp_gym.envs.core.period_source import PeriodSource
from prp_gym.envs.vector import PRPVectorEnv
from prp_gym.errors import MissingFieldError, UnknownNameError
from prp_gym.tasks import SCENARIOS
from tests.support.compiler import needs_compiler
from tests.support.pinocchio_model import Array

pytestmark = needs_compiler

COUNT = 3
SMOOTH, SOLVER = 1e-9, 1e-5
"""Largest difference of a number after a control period from the same state, relative to 1 + |number|:
rounding where the surface is the only constraint; where there are several, joint stops or Coulomb friction,
the tolerance at which MuJoCo's solver stops."""


def made(environment_id: str, **keywords: Any) -> PRPVectorEnv:
    env = gymnasium.make_vec(environment_id, num_envs=COUNT, num_threads=1, **keywords)
    assert isinstance(env, PRPVectorEnv)
    return env


def difference(left: Array, right: Array) -> float:
    return float((np.abs(left - right) / (1.0 + np.abs(left))).max())


def follow(reference: PRPVectorEnv, compiled: PRPVectorEnv) -> None:
    """Put the compiled simulations where those of MuJoCo are."""
    everyone = np.arange(COUNT)
    physics = reference.physics
    compiled.physics.reset(everyone, physics.joint_position.copy(), physics.joint_velocity.copy())


def check_same(reference: PRPVectorEnv, compiled: PRPVectorEnv, steps: int, tolerance: float) -> None:
    """Smooth random actions on both, from the same state at every step."""
    rng = np.random.default_rng(7)
    first, second = reference.reset(seed=5), compiled.reset(seed=5)
    assert difference(first[0], second[0]) < tolerance
    action = np.zeros(reference.action_space.shape or ())
    for _ in range(steps):
        action = np.clip(0.9 * action + 0.3 * rng.uniform(-1.0, 1.0, action.shape), -1.0, 1.0)
        follow(reference, compiled)
        one, other = reference.step(action), compiled.step(action)
        assert difference(one[0], other[0]) < tolerance
        assert difference(one[1], other[1]) < tolerance
        assert (one[2] == other[2]).all()
        assert (one[3] == other[3]).all()
        for name, values in one[4].items():
            if name.startswith("cost_"):
                assert (values == other[4][name]).all(), name
            else:
                assert difference(np.asarray(values, float), np.asarray(other[4][name], float)) < tolerance


@pytest.mark.parametrize("scenario", SCENARIOS)
@pytest.mark.parametrize("environment_id", prp_gym.list_envs())
def test_a_whole_episode_is_that_of_mujoco(environment_id: str, scenario: str) -> None:
    keywords = {"scenario": scenario, "control_frequency": 250, "duration": 1.0}
    tolerance = SMOOTH if scenario == "report" else SOLVER
    check_same(
        made(environment_id, **keywords), made(environment_id, engine="compiled", **keywords), 260, tolerance
    )


def modes() -> list[tuple[str, str, str]]:
    """Every action mode on a task that has it, with the scenarios in turn."""
    found: dict[str, str] = {}
    for environment_id in prp_gym.list_envs():
        layout = made(environment_id).task.layout
        for mode in list_action_modes(layout):
            if mode != "torque":
                found.setdefault(mode, environment_id)
    scenarios = itertools.cycle(SCENARIOS)
    return [(mode, environment_id, next(scenarios)) for mode, environment_id in found.items()]


@pytest.mark.parametrize(("mode", "environment_id", "scenario"), modes())
def test_action_modes_are_those_of_mujoco(mode: str, environment_id: str, scenario: str) -> None:
    keywords = {"scenario": scenario, "action_mode": mode, "control_frequency": 100}
    tolerance = 1e3 * SOLVER  # an inner controller amplifies differences over the periods of an action
    check_same(
        made(environment_id, **keywords), made(environment_id, engine="compiled", **keywords), 20, tolerance
    )


def score(environment_id: str, name: str, engine: str) -> Array:
    """Mean rewards of a controller at the start of an episode."""
    env = made(environment_id, engine=engine, scenario="randomized", duration=0.3)
    controller = make_baseline(name, env)
    observation, _ = env.reset(seed=11)
    state, total = None, np.zeros(COUNT)
    for step in range(150):
        action, state = controller.predict(observation, state, np.full(COUNT, step == 0))
        observation, reward, *_ = env.step(action)
        total += reward
    return total / 150


@pytest.mark.parametrize("environment_id", prp_gym.list_envs())
def test_controllers_have_the_same_score(environment_id: str) -> None:
    """In closed loop differences stay rounding: 1e-6 of a score is asked for."""
    for name in CONTROLLERS:
        try:
            mujoco, compiled = (score(environment_id, name, engine) for engine in ("mujoco", "compiled"))
        except MissingFieldError:
            continue
        assert compiled == pytest.approx(mujoco, abs=1e-6), name


def test_the_state_is_restored_and_pickled_bit_for_bit() -> None:
    env = made("PRP-Force-v0", engine="compiled", scenario="realistic")
    env.reset(seed=2)
    action = np.full(env.action_space.shape or (), 0.1)
    for _ in range(30):
        env.step(action)
    state, twin = env.get_state(), pickle.loads(pickle.dumps(env))
    expected = env.step(action)
    assert (twin.step(action)[0] == expected[0]).all()
    env.step(action)
    env.set_state(state)
    assert (env.step(action)[0] == expected[0]).all()


def test_frames_are_those_of_mujoco() -> None:
    frames = []
    for engine in ("mujoco", "compiled"):
        env = gymnasium.make("PRP-Impedance-v0", engine=engine, render_mode="rgb_array", width=64, height=48)
        env.reset(seed=4)
        frames.append(np.asarray(env.render()).astype(int))
        env.close()
    assert np.abs(frames[0] - frames[1]).max() <= 1  # one level of a colour, by rounding


def test_single_and_vectorised_environments_have_the_same_bits() -> None:
    env = gymnasium.make("PRP-ForcePosition-v0", engine="compiled", scenario="realistic")
    many = made("PRP-ForcePosition-v0", engine="compiled", scenario="realistic")
    alone, _ = env.reset(seed=8)
    together, _ = many.reset(seed=7)
    assert (alone == together[1]).all()
    for _ in range(50):
        action = np.array([0.1, -0.05, 0.02])
        alone, reward, *_ = env.step(action)
        together, rewards, *_ = many.step(np.tile(action, (COUNT, 1)))
        assert (alone == together[1]).all()
        assert reward == rewards[1]


def test_another_engine_is_refused() -> None:
    with pytest.raises(UnknownNameError, match="engine"):
        gymnasium.make("PRP-Force-v0", engine="bullet")


@pytest.mark.parametrize("environment_id", prp_gym.list_envs())
def test_reference_of_every_task_is_computed_in_compiled_code(environment_id: str) -> None:
    """Without a sampling ahead in NumPy, which takes as long as the rest of a step."""
    with closing(gymnasium.make(environment_id, engine="compiled")) as env:
        env.reset(seed=0)
        loop: Any = env.unwrapped.loop  # type: ignore[attr-defined]
        assert PeriodSource(loop).references is not None
