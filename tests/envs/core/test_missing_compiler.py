"""Without a compiler: NumPy computes what the package has no library for, with the same bits."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

import prp_gym
from prp_gym.errors import CompilerError
from prp_gym.symbolic import compiler
from prp_gym.symbolic.compiler import build_library
from prp_gym.tasks.setup import COMPILED, MUJOCO
from tests.support.compiler import forget_compiler, lose_compiler, needs_compiler

pytestmark = needs_compiler

ADAPTIVE = "PRP-Adaptive-v0"
SHORT = {"scenario": "realistic", "duration": 0.1}
MODE = {"action_mode": "joint_position", "control_frequency": 50}


@pytest.fixture(autouse=True)
def libraries(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder of the package's libraries, which has none yet, for a new process."""
    monkeypatch.setattr(compiler, "PREBUILT", tmp_path)
    monkeypatch.delenv("PRP_GYM_COMPILED", raising=False)
    yield tmp_path
    forget_compiler()


def make(**keywords: Any) -> Any:
    return gymnasium.make(ADAPTIVE, **{**SHORT, **keywords}).unwrapped


def steps(env: Any) -> list[bytes]:
    """The bits of an episode."""
    env.reset(seed=3)
    action = np.full(env.action_space.shape, 0.3, dtype=np.float32)
    results = []
    ended = False
    while not ended:
        observation, reward, _, ended, info = env.step(action)
        numbers = [float(value) for value in info.values() if isinstance(value, float)]
        results += [observation.tobytes(), np.array([reward, *numbers]).tobytes()]
    return results


def episodes(env: Any) -> list[bytes]:
    """The bits of episodes with a controller."""
    evaluation = prp_gym.evaluate(prp_gym.make_baseline("adaptive", env), env, episodes=2)
    return [part.tobytes() for own in evaluation.rollouts for part in (own.torque, own.reward)]


def test_compiled_engine_without_any_library_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    lose_compiler(monkeypatch)
    with pytest.raises(CompilerError, match="install gcc or clang, or: pip install ziglang"):
        make(engine=COMPILED)


@pytest.mark.parametrize("keywords", [{}, MODE])
def test_physics_alone_is_enough_for_the_compiled_engine(
    keywords: dict[str, Any], libraries: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with_compiler = make(engine=COMPILED, **keywords)
    expected = steps(with_compiler)
    build_library(with_compiler.loop.physics.source, libraries)
    lose_compiler(monkeypatch)
    assert steps(make(engine=COMPILED, **keywords)) == expected


def test_controller_without_a_library_runs_period_by_period(
    libraries: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with_compiler = make(engine=COMPILED)
    expected = episodes(with_compiler)
    build_library(with_compiler.loop.physics.source, libraries)
    lose_compiler(monkeypatch)
    assert episodes(make(engine=COMPILED)) == expected


def test_mujoco_needs_no_library(monkeypatch: pytest.MonkeyPatch) -> None:
    expected = steps(make(engine=MUJOCO))
    lose_compiler(monkeypatch)
    assert steps(make(engine=MUJOCO)) == expected
