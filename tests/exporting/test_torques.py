"""Exported controllers in C: the torques and states of Python, over whole sequences with their state."""

from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

from prp_gym.baselines import Baseline
from prp_gym.exporting import c_header
from tests.exporting.compiled_header import (
    Array,
    CompiledHeader,
    compile_headers,
    controllers,
    of_python,
    recorded,
    varied,
)
from tests.support.compiler import needs_compiler

pytestmark = needs_compiler

LARGEST_ERROR = 1e-12
"""Of torques by the torque limit, and of states by their size: sums of some hundred products, each rounded to
1e-16 of terms up to ten times as large as the limit, and sines of another library."""

FORCE, CONTROLLER = "PRP-ForcePosition-v0", "force_inner_position"
KINDS = ("PRP-Adaptive-v0", "PRP-JointTracking-v0", "PRP-PoseRegulation-v0", "PRP-Force-v0")
"""An environment of every kind of robot and reference."""


def check(compiled: CompiledHeader, policy: Baseline[Any], observations: Array) -> tuple[Array, Array]:
    """Compare torques (E, T, joints) and final states (E, states) with those of Python, and return these."""
    torque, state = compiled.run(observations)
    expected, final = of_python(policy, observations)
    errors = np.abs((torque - expected) / policy.interface.torque_limit)
    assert errors.max() < LARGEST_ERROR, policy
    assert np.max(np.abs(state - final) / (1.0 + np.abs(final)), initial=0.0) < LARGEST_ERROR, policy
    return expected, final


def test_a_million_steps_of_a_controller_with_state(tmp_path: Path) -> None:
    controller = controllers(FORCE)[CONTROLLER]
    (compiled,) = compile_headers([c_header(controller)], tmp_path, "-O2")
    sequences = varied(recorded(FORCE, CONTROLLER, 8, 500), 250)
    assert sequences.shape[0] * sequences.shape[1] == 1_000_000
    torque, state = check(compiled, controller, sequences)
    limited = np.abs(torque) == controller.interface.torque_limit
    assert 0.1 < limited.mean() < 0.9  # torques at the limits, and within them
    assert state.shape[1] > 40
    assert np.ptp(state, axis=0).max() > 0.1


@pytest.mark.parametrize("environment_id", KINDS)
def test_ten_thousand_steps_of_every_controller(environment_id: str, tmp_path: Path) -> None:
    policies = controllers(environment_id)
    sequences = varied(recorded(environment_id, next(iter(policies)), 10, 100), 10)
    assert sequences.shape[0] * sequences.shape[1] == 10_000
    compiled = compile_headers([c_header(policy) for policy in policies.values()], tmp_path)
    for program, policy in zip(compiled, policies.values(), strict=True):
        torque, _ = check(program, policy, sequences)
        assert np.ptp(torque, axis=(0, 1)).min() > 0.0, policy


def test_exported_controller_controls_the_robot_as_python_does(tmp_path: Path) -> None:
    controller = controllers(FORCE)[CONTROLLER]
    (compiled,) = compile_headers([c_header(controller)], tmp_path)
    env = gymnasium.make(FORCE, scenario="realistic")
    observation, _ = env.reset(seed=11)
    state, torque, before = np.zeros(compiled.state_size), np.zeros(3), None
    assert compiled.begin(observation.astype(np.float64), state) == 0
    for period in range(400):
        assert compiled.step(observation.astype(np.float64), state, torque) == 0
        action, before = controller.predict(observation, before, np.array([period == 0]))
        # an action is the torque by its limit, rounded to single precision
        limit = controller.interface.torque_limit
        np.testing.assert_allclose(torque / limit, action, rtol=6e-8, atol=1e-12)
        observation, *_ = env.step((torque / limit).astype(np.float32))
    env.close()
