"""The closed form of the link against MuJoCo and against the exact motion of a pendulum."""

import copy

import numpy as np

from prp_gym.physics import LinkPhysics
from prp_gym.physics.compiled_link import CompiledLink
from tests.support.compiler import needs_compiler

pytestmark = needs_compiler

COUNT = 8
IDS = np.arange(COUNT)
ROUNDING = 1e-12


def both() -> tuple[LinkPhysics, CompiledLink]:
    rng = np.random.default_rng(3)
    two = LinkPhysics(num_simulations=COUNT), CompiledLink(num_simulations=COUNT)
    numbers = rng.uniform(0.2, 2.0, (3, COUNT))
    start = rng.uniform(-3.0, 3.0, (2, COUNT, 1))
    for physics in two:
        physics.set_parameters(IDS, *numbers)
        physics.reset(IDS, *start)
    return two


def test_a_step_is_that_of_mujoco() -> None:
    reference, compiled = both()
    rng = np.random.default_rng(5)
    for _ in range(200):
        compiled.reset(IDS, reference.joint_position, reference.joint_velocity)
        torque = rng.normal(size=(COUNT, 1)) * 5.0
        for physics in (reference, compiled):
            physics.set_torque(torque)
            physics.advance(2)
        assert np.abs(reference.measurement - compiled.measurement).max() < ROUNDING * 100.0
        assert np.abs(reference.tip_position - compiled.tip_position).max() < ROUNDING * 100.0


def test_a_copy_goes_on_bit_for_bit() -> None:
    _, physics = both()
    twin = copy.deepcopy(physics)
    for each in (physics, twin):
        each.advance(50)
    assert physics.measurement.tobytes() == twin.measurement.tobytes()


def test_mujoco_draws_the_same_state() -> None:
    reference, physics = both()
    assert np.allclose(reference.data(2).site("tip").xpos, physics.data(2).site("tip").xpos, atol=ROUNDING)
    assert physics.model(2).dof_damping == reference.model(2).dof_damping
    assert not physics.contact_force.any()
