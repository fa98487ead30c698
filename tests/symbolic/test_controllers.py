"""Every controller on every task: its traced control law gives exactly the numbers of its NumPy formulas."""

from collections.abc import Mapping
from contextlib import closing
from functools import cache
from typing import Any

import gymnasium
import numpy as np
import pytest

from prp_gym.baselines import CONTROLLERS, Baseline, list_baselines, make_baseline
from prp_gym.symbolic.function import SymbolicFunction, trace
from prp_gym.tasks.registration import list_envs
from tests.symbolic.compilation import Array, CompiledFunction, compile_together

OBSERVATIONS = 6
NOISE = (0.01, 0.3)  # of observations, in their own units: near an episode's start, and anywhere
DRIFT = 0.01  # of states
Results = tuple[Array, ...]


def named_state(state: Results) -> dict[str, Array]:
    return {f"state_{index}": part for index, part in enumerate(state)}


def control_law(policy: Baseline[Any], observation: Array) -> SymbolicFunction:
    """Torque and next state as a function of an observation (1, size) and the state before."""
    layout = policy.interface.layout

    def control(observation: Any, **state: Any) -> Mapping[str, Any]:
        observed = {name: observation[..., part] for name, part in layout.slices.items()}
        torque, after = policy.control(observed, tuple(state.values()))
        return {"torque": torque, **{f"after_{index}": part for index, part in enumerate(after)}}

    state = policy.initial_state(layout.split(observation))
    shapes = {"observation": observation.shape, **{k: part.shape for k, part in named_state(state).items()}}
    name = "control_" + "".join(letter if letter.isalnum() else "_" for letter in policy.origin.controller)
    return trace(name, control, shapes)


@cache
def controllers(environment_id: str) -> tuple[dict[str, Baseline[Any]], Array]:
    """The controllers of a task that can be traced, by name, and the first observation (1, size)."""
    with closing(gymnasium.make(environment_id, scenario="realistic")) as env:
        observation, _ = env.reset(seed=3)
        names = list_baselines(env.get_wrapper_attr("observation_layout"))
        traced_ones = [name for name in names if CONTROLLERS.find(name).policy.compiled]
        return {name: make_baseline(name, env) for name in traced_ones}, observation[None].astype(np.float64)


def traced(environment_id: str) -> dict[str, SymbolicFunction]:
    policies, observation = controllers(environment_id)
    return {name: control_law(policy, observation) for name, policy in policies.items()}


def cases(policy: Baseline[Any], first: Array) -> list[tuple[Array, Results]]:
    """Observations, each with a state near the one that those before lead to."""
    generator = np.random.default_rng(0)
    split = policy.interface.layout.split
    state, found = policy.initial_state(split(first)), []
    for index in range(OBSERVATIONS):
        noise = NOISE[index % len(NOISE)]
        observation = first + generator.normal(scale=noise, size=first.shape)
        state = tuple(part + DRIFT * generator.random(part.shape) for part in state)
        found.append((observation, state))
        _, state = policy.control(split(observation), state)
    return found


def of_numpy(policy: Baseline[Any], observation: Array, state: Results) -> dict[str, Array]:
    torque, after = policy.control(policy.interface.layout.split(observation), state)
    return {"torque": torque, **{f"after_{index}": part for index, part in enumerate(after)}}


def assert_same_numbers(found: Mapping[str, Array], expected: Mapping[str, Array], controller: str) -> None:
    assert found.keys() == expected.keys()
    for name, values in expected.items():
        assert np.isfinite(values).all(), controller
        np.testing.assert_array_equal(found[name], values, err_msg=f"{name} of {controller}")


@pytest.mark.parametrize("environment_id", list_envs())
def test_compiled_control_laws_are_those_of_numpy(environment_id: str) -> None:
    policies, first = controllers(environment_id)
    functions = traced(environment_id)
    compiled: dict[str, CompiledFunction] = compile_together(functions.values())
    assert len(compiled) == len(policies) > 0
    for name, policy in policies.items():
        code = compiled[functions[name].name]
        torques = []
        for observation, state in cases(policy, first):
            expected = of_numpy(policy, observation, state)
            found = code({"observation": observation, **named_state(state)})
            assert_same_numbers(found, expected, name)
            torques.append(expected["torque"])
        assert np.ptp(np.array(torques), axis=0).max() > 0.0, name  # the observations differ


@pytest.mark.parametrize("environment_id", list_envs())
def test_traced_control_laws_are_those_of_numpy(environment_id: str) -> None:
    policies, first = controllers(environment_id)
    for name, function in traced(environment_id).items():
        for observation, state in cases(policies[name], first)[:2]:
            expected = of_numpy(policies[name], observation, state)
            found = function.evaluate({"observation": observation, **named_state(state)})
            assert_same_numbers(found, expected, name)
