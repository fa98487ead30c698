"""Generated code that the compiler rejects is an error wherever NumPy stands in for a missing compiler."""

import re
from collections.abc import Callable, Iterator
from ctypes import CDLL
from pathlib import Path
from typing import Any

import gymnasium
import pytest

import prp_gym
from prp_gym.cli.compiler_note import note_missing_compiler
from prp_gym.console.terminal import Terminal
from prp_gym.errors import CompilerError, GeneratedCodeError
from prp_gym.symbolic.compiler import load_library
from prp_gym.tasks.setup import COMPILED, ENGINES, MUJOCO
from prp_gym.tuning.episodes import Episodes
from tests.support.compiler import choose_compiler, forget_compiler, needs_compiler

ADAPTIVE, TRACKING = "PRP-Adaptive-v0", "PRP-JointTracking-v0"
MODE = {"action_mode": "joint_position", "control_frequency": 50}
PERIODS = "prp_gym.envs.core.compiled_run"
METHODS = "prp_gym.symbolic.compiled_method"  # controllers and action modes
ITERATION = "prp_gym.baselines.predictive.iteration"
BROKEN = """
void prp_broken(const double *restrict sin, double *restrict sin)
{
    sin[0] = 1.0;
}
"""
"""Two arguments of one name, as a formula's inputs might have."""


@pytest.fixture(autouse=True)
def new_process(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Compiled code is not turned off, and nothing is known of a compiler after a test."""
    monkeypatch.delenv("PRP_GYM_COMPILED", raising=False)
    monkeypatch.setenv("PRP_GYM_CACHE", str(tmp_path / "cache"))
    yield
    forget_compiler()


def break_code(monkeypatch: pytest.MonkeyPatch, module: str) -> None:
    """A module adds a function to its code that no compiler takes."""

    def load_broken(source: str) -> CDLL:
        return load_library(source + BROKEN)

    monkeypatch.setattr(f"{module}.load_library", load_broken)


def make(environment_id: str = ADAPTIVE, **keywords: Any) -> Any:
    return gymnasium.make(environment_id, scenario="realistic", duration=0.1, **keywords).unwrapped


def step_twice(env: Any) -> None:
    """The second step of an action mode is that which compiled code computes."""
    env.reset(seed=0)
    for _ in range(2):
        env.step(env.action_space.sample() * 0.0)


def evaluate(env: Any) -> None:
    prp_gym.evaluate(prp_gym.make_baseline("adaptive", env), env, episodes=1)


def search(env: Any) -> None:
    Episodes(env, [0]).run_all([prp_gym.make_baseline("adaptive", env)])


def plan(env: Any) -> None:
    env.reset(seed=0)
    prp_gym.evaluate(prp_gym.make_baseline("model_predictive", env), env, episodes=1)


@needs_compiler
@pytest.mark.parametrize(
    ("module", "run", "keywords"),
    [
        *((PERIODS, step_twice, {"engine": engine}) for engine in ENGINES),
        (METHODS, step_twice, {"engine": COMPILED, **MODE}),
        *((METHODS, evaluate, {"engine": engine}) for engine in ENGINES),
        (METHODS, search, {"engine": COMPILED}),
        *((ITERATION, plan, {"environment_id": TRACKING, "engine": engine}) for engine in ENGINES),
    ],
)
def test_rejected_code_is_an_error_that_names_the_function(
    module: str, run: Callable[[Any], None], keywords: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    env = make(**keywords)
    break_code(monkeypatch, module)
    with pytest.raises(GeneratedCodeError, match="function 'prp_broken'") as rejected:
        run(env)
    assert "sin" in rejected.value.messages


@needs_compiler
@pytest.mark.parametrize("module", [PERIODS, METHODS])
def test_nothing_is_compiled_where_that_is_turned_off(module: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PRP_GYM_COMPILED", "0")
    break_code(monkeypatch, module)
    evaluate(make(engine=MUJOCO))


@pytest.mark.parametrize(
    ("program", "fault"),
    [
        ('echo "$*:1:1: error: wrong" >&2; exit 1', "own-compiler failed: .*error: wrong"),
        ("exit 0", "what .*own-compiler has compiled cannot be loaded"),
    ],
)
def test_compiler_that_does_not_work_is_as_good_as_none(
    program: str,
    fault: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    choose_compiler(monkeypatch, tmp_path / "own-compiler", program)
    evaluate(make(engine=MUJOCO))
    with pytest.raises(CompilerError, match=fault):
        make(engine=COMPILED)
    note_missing_compiler(Terminal())
    assert re.match(f"compiled code needs a C compiler, and .*{fault}", capsys.readouterr().err, re.DOTALL)
