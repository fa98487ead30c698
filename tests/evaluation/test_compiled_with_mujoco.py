"""Whole episodes with MuJoCo's physics and the controller in compiled code: the bits are those of NumPy."""

from itertools import cycle
from typing import Any

import gymnasium
import pytest

from prp_gym.baselines import CONTROLLERS, make_baseline
from prp_gym.envs.core.compiled_run import CompiledPeriods
from prp_gym.evaluation.batch import record_episodes
from prp_gym.evaluation.compiled_batch import record_compiled
from prp_gym.evaluation.compiled_controller import CompiledController
from prp_gym.evaluation.rollout import Rollout
from prp_gym.tasks import SCENARIOS
from tests.support.compiled_episodes import assert_same_episodes
from tests.support.compiler import needs_compiler
from tests.support.controller_episodes import COMBINATIONS

pytestmark = [needs_compiler, pytest.mark.usefixtures("timed_once")]

BRIEF = 0.08  # duration [s]: 40 periods, in which a start in contact, delays and integrators show
FORCE = "PRP-Force-v0"
TRACED = [
    (environment_id, name, scenario)
    for (environment_id, name), scenario in zip(COMBINATIONS, cycle(SCENARIOS), strict=False)
    if CONTROLLERS.find(name).policy.compiled
]


def in_numpy(policy: Any, env: Any, seeds: tuple[int, ...], monkeypatch: pytest.MonkeyPatch) -> list[Rollout]:
    """Episodes of which NumPy computes all but the physics."""
    with monkeypatch.context() as patched:
        patched.setenv("PRP_GYM_COMPILED", "0")
        return record_episodes(policy, env, seeds)


def brief(environment_id: str, scenario: str = "realistic") -> Any:
    return gymnasium.make(environment_id, scenario=scenario, duration=BRIEF).unwrapped


@pytest.mark.parametrize(("environment_id", "name", "scenario"), TRACED)
def test_every_controller_has_the_episodes_that_numpy_computes(
    environment_id: str, name: str, scenario: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    env = brief(environment_id, scenario)
    policy = make_baseline(name, env)
    found = record_compiled(policy, env, (3, 8))
    assert found is not None
    assert_same_episodes(found, in_numpy(policy, env, (3, 8), monkeypatch))


def test_episodes_with_a_simulation_that_is_lost_are_left_to_numpy(monkeypatch: pytest.MonkeyPatch) -> None:
    env = brief(FORCE)
    policy, advance = make_baseline("impedance", env), CompiledPeriods._advance_mujoco
    monkeypatch.setattr(
        CompiledPeriods, "_advance_mujoco", lambda self, *given: given[1] < 7 and advance(self, *given)
    )
    assert record_compiled(policy, env, (3, 8)) is None
    assert_same_episodes(record_episodes(policy, env, (3, 8)), in_numpy(policy, env, (3, 8), monkeypatch))


def test_action_that_is_not_finite_is_left_to_numpy(monkeypatch: pytest.MonkeyPatch) -> None:
    env = brief(FORCE)
    policy = make_baseline("impedance", env)
    given = CompiledController.__init__

    def without_numbers(self: CompiledController, *arguments: Any) -> None:
        given(self, *arguments)
        self.numbers = self.numbers * float("nan")

    monkeypatch.setattr(CompiledController, "__init__", without_numbers)
    assert record_compiled(policy, env, (3,)) is None


def test_functions_whose_bits_are_not_those_of_numpy_are_left_to_numpy(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    env = brief(FORCE)
    monkeypatch.setattr(CompiledController, "has_bits_of_numpy", False)
    assert record_compiled(make_baseline("impedance", env), env, (3,)) is None
