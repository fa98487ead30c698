"""The closed form of the arm against MuJoCo, step by step from the same state, in every kind of world."""

import copy
import itertools
import pickle
from dataclasses import fields

import mujoco
import numpy as np
import pytest

from prp_gym.errors import InvalidValueError, NonFiniteError, ShapeError
from prp_gym.physics import Physics, PhysicsSettings, Surface
from prp_gym.physics.compiled_arm import CompiledArm
from prp_gym.robot import PRPArm
from tests.support.compiler import needs_compiler
from tests.support.pinocchio_model import Array

pytestmark = needs_compiler

COUNT, STEPS, SUBSTEPS = 24, 250, 2
IDS = np.arange(COUNT)
SPREAD = np.array([4.0, 20.0, 2.0])  # of random torques [N m, N, N m]
SMOOTH = 1e-9
"""Largest difference after a control period, relative to 1 + |value|: rounding of two orders of summation."""
COULOMB = 1e-5
"""The same with Coulomb friction: MuJoCo's solver stops at a tolerance, the closed form at the minimum."""

WORLDS = list(itertools.product((False, True), repeat=3))  # joint stops, surface, Coulomb friction


def random_surface(rng: np.random.Generator, q: Array) -> Surface:
    """Planes within a centimetre of the tips, in any direction, from soft to stiff."""
    normal = rng.normal(size=(COUNT, 3))
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    tip = PRPArm().forward_kinematics(q)[:, :3]
    offset = (normal * tip).sum(axis=1) + rng.uniform(-0.01, 0.01, COUNT)
    stiffness = np.exp(rng.uniform(np.log(50.0), np.log(2e4), COUNT))
    return Surface(stiffness, rng.uniform(0.0, 20.0, COUNT), normal, offset)


def both(stops: bool, surface: bool, coulomb: bool, seed: int = 1) -> tuple[Physics, CompiledArm]:
    """The same random arms in MuJoCo and in closed form."""
    rng = np.random.default_rng(seed)
    settings = PhysicsSettings(0.001, stops, surface)
    engines = Physics(settings=settings, num_simulations=COUNT), CompiledArm(settings, COUNT)
    q = rng.uniform([-2.0, -0.3, -3.0], [2.0, 0.0, 3.0], (COUNT, 3))
    velocity = rng.normal(size=(COUNT, 3))
    dynamics = rng.uniform(0.7, 1.4, (COUNT, 3)), rng.uniform(0.0, 0.5, (COUNT, 3))
    friction = rng.uniform(0.05, 0.5, (COUNT, 3)) * coulomb
    planes = random_surface(rng, q)
    for physics in engines:
        physics.set_dynamics(IDS, *dynamics, friction)
        if surface:
            physics.set_surface(IDS, planes)
        physics.reset(IDS, q, velocity)
    return engines


def difference(left: Array, right: Array) -> float:
    return float((np.abs(left - right) / (1.0 + np.abs(left))).max())


@pytest.mark.parametrize(("stops", "surface", "coulomb"), WORLDS)
def test_a_step_is_that_of_mujoco(stops: bool, surface: bool, coulomb: bool) -> None:
    reference, compiled = both(stops, surface, coulomb)
    rng, tolerance, touching, stopped = np.random.default_rng(2), COULOMB if coulomb else SMOOTH, 0, 0
    for _ in range(STEPS):
        torque = rng.normal(size=(COUNT, 3)) * SPREAD
        compiled.reset(IDS, reference.joint_position, reference.joint_velocity)
        for physics in (reference, compiled):
            physics.set_torque(torque)
            physics.advance(SUBSTEPS)
        near = ~reference.out_of_bounds  # without stops some leave the bounds, where the closed form ends
        assert difference(reference.measurement[near], compiled.measurement[near]) < tolerance
        assert difference(reference.stop_violation[near], compiled.stop_violation[near]) < tolerance
        assert (reference.joints_at_stop == compiled.joints_at_stop)[near].all()
        touching += int(np.count_nonzero(reference.contact_force))
        stopped += int(np.count_nonzero(reference.joints_at_stop))
    assert (touching > STEPS) == surface
    assert (stopped > STEPS) == stops


@pytest.mark.parametrize(("stops", "surface", "coulomb"), WORLDS)
def test_without_its_tolerance_the_solver_of_mujoco_finds_the_same(
    stops: bool, surface: bool, coulomb: bool
) -> None:
    """What is left of the difference, also with Coulomb friction, is rounding."""
    reference, compiled = both(stops, surface, coulomb)
    torque = np.random.default_rng(3).normal(size=(COUNT, 3)) * SPREAD
    compiled.set_torque(torque)
    compiled.advance(1)
    for row in range(COUNT):
        model, data = reference.model(row), reference.data(row)
        model.opt.tolerance, model.opt.iterations = 0.0, 1000
        data.ctrl[:] = torque[row]
        mujoco.mj_step(model, data)
        assert difference(data.qvel, compiled.joint_velocity[row]) < 1e-11


def test_measurements_after_a_reset_are_those_of_mujoco() -> None:
    reference, compiled = both(True, True, True)
    assert difference(reference.measurement, compiled.measurement) < SMOOTH
    assert difference(reference.tip_velocity, compiled.tip_velocity) < SMOOTH
    assert difference(reference.tip_position, compiled.tip_position) < SMOOTH
    assert np.count_nonzero(compiled.contact_force)


def test_the_bits_depend_neither_on_the_number_of_simulations_nor_on_threads() -> None:
    many = CompiledArm(PhysicsSettings(0.001, True, True), 256, 2)
    one = CompiledArm(PhysicsSettings(0.001, True, True), 1)
    rng, rows = np.random.default_rng(4), np.arange(256)
    q = rng.uniform([-2.0, -0.3, -3.0], [2.0, 0.0, 3.0], (256, 3))
    factor, friction = rng.uniform(0.8, 1.2, (256, 3)), rng.uniform(0.0, 0.3, (256, 3))
    plane = Surface.single(500.0, (0.0, -1.0, 0.0), 0.2, 3.0)
    planes = Surface(*(np.repeat(getattr(plane, part.name), 256, axis=0) for part in fields(Surface)))
    many.set_dynamics(rows, factor, friction, friction)
    many.set_surface(rows, planes)
    many.reset(rows, q, np.zeros((256, 3)))
    one.set_dynamics(rows[:1], factor[200:201], friction[200:201], friction[200:201])
    one.set_surface(rows[:1], plane)
    one.reset(rows[:1], q[200:201], np.zeros((1, 3)))
    for _ in range(100):
        torque = rng.normal(size=(256, 3)) * SPREAD
        many.set_torque(torque)
        one.set_torque(torque[200:201])
        many.advance(SUBSTEPS)
        one.advance(SUBSTEPS)
        assert many.measurement[200].tobytes() == one.measurement[0].tobytes()


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda value: pickle.loads(pickle.dumps(value))])
def test_a_copy_goes_on_bit_for_bit(copied: object) -> None:
    _, physics = both(True, True, True)
    assert callable(copied)
    physics.watch(np.full(6, 50.0))
    physics.set_torque(np.tile(SPREAD, (COUNT, 1)))
    physics.advance(5)
    twin: CompiledArm = copied(physics)
    for each in (physics, twin):
        each.advance(20)
    assert physics.measurement.tobytes() == twin.measurement.tobytes()
    assert (physics.torque == twin.torque).all()


def test_a_snapshot_is_restored_bit_for_bit() -> None:
    _, physics = both(True, True, True)
    state = physics.snapshot()
    physics.set_torque(np.tile(SPREAD, (COUNT, 1)))
    physics.set_dynamics(IDS, np.ones((COUNT, 3)), np.ones((COUNT, 3)), np.ones((COUNT, 3)))
    physics.advance(5)
    physics.restore(state)
    again = physics.snapshot()
    assert (state.integration == again.integration).all()
    assert all((values == again.model_fields[name]).all() for name, values in state.model_fields.items())
    other = CompiledArm(physics.settings, 2)
    with pytest.raises(InvalidValueError, match="snapshot"):
        other.restore(state)


def test_mujoco_draws_the_same_state() -> None:
    reference, physics = both(True, True, True)
    assert difference(reference.data(3).site("tip").xpos, physics.data(3).site("tip").xpos) < SMOOTH
    assert physics.model(3).body_mass == pytest.approx(reference.model(3).body_mass, rel=1e-12)
    assert physics.surface(3).stiffness == pytest.approx(reference.surface(3).stiffness, rel=1e-12)
    free = CompiledArm(PhysicsSettings(0.001, True, True), 1)
    assert free.model().nbody == reference.model().nbody


def test_springs_change_where_the_surface_stays() -> None:
    reference, compiled = both(False, True, False)
    soft, damping = np.full(COUNT, 100.0), np.full(COUNT, 2.0)
    for physics in (reference, compiled):
        physics.set_springs(IDS, soft, damping)
        physics.advance(SUBSTEPS)
    assert difference(reference.contact_force, compiled.contact_force) < SMOOTH
    with pytest.raises(InvalidValueError, match="surface"):
        CompiledArm(PhysicsSettings(surface=True)).set_springs(IDS[:1], soft[:1], damping[:1])
    with pytest.raises(InvalidValueError, match="surface"):
        CompiledArm(PhysicsSettings(surface=True)).surface()


def test_a_simulation_beyond_the_bounds_stays_there_and_the_others_go_on() -> None:
    physics = CompiledArm(PhysicsSettings(0.001, False, False), 2)
    physics.watch(np.array([1e3, 2.0, 1e3, 1e3, 1e3, 1e3]))
    physics.set_torque(np.array([[0.0, 1e3, 0.0], [0.0, 0.0, 0.5]]))
    for _ in range(100):
        physics.advance(10)
    assert physics.out_of_bounds.tolist() == [True, False]
    assert not physics.within_limits
    gone, there = physics.joint_position.copy(), physics.measurement
    physics.advance(10)
    assert (physics.joint_position[0] == gone[0]).all()
    assert (physics.joint_position[1] != gone[1]).any()
    assert np.isfinite(there).all()
    physics.reset(IDS[:1], np.zeros((1, 3)), np.zeros((1, 3)))
    assert physics.within_limits


def test_numbers_that_are_not_finite_never_become_a_state() -> None:
    physics = CompiledArm(PhysicsSettings(0.001, False, False))
    with pytest.raises(NonFiniteError):
        physics.reset(IDS[:1], np.full((1, 3), np.nan), np.zeros((1, 3)))
    with pytest.raises(ShapeError):
        physics.reset(IDS[:1], np.zeros((2, 3)), np.zeros((1, 3)))
    physics.set_torque(np.full((1, 3), 1e308))
    physics.advance(50)
    assert np.isfinite(physics.measurement).all()
    assert physics.out_of_bounds.all()


def test_what_the_closed_form_lacks_is_refused() -> None:
    with pytest.raises(InvalidValueError, match="surface_friction"):
        CompiledArm(PhysicsSettings(surface=True, surface_friction=0.3))
    with pytest.raises(InvalidValueError, match="at least 1"):
        CompiledArm(num_simulations=0)
    with pytest.raises(InvalidValueError, match="without a surface"):
        CompiledArm().set_surface(IDS[:1], Surface.single(1.0, (0.0, 0.0, 1.0), 0.0))
    with pytest.raises(InvalidValueError, match="mujoco"):
        _ = CompiledArm().batch
