"""The contract of the elastic surface: what the tip feels is the ideal spring and damper, and only that."""

import numpy as np
import pytest

from prp_gym.errors import InvalidValueError
from prp_gym.physics import Physics, PhysicsSettings, Surface
from prp_gym.robot import PRPArm
from tests.support.pinocchio_model import Array

ARM = PRPArm()
K_P, K_D = 50.0, 10.0  # of compliance control [N/m, N s/m]
TARGET = ARM.forward_kinematics((0.0, -0.2, 0.0))  # 0.1 m behind the plane y = -0.44
PLANE, OFFSET = (0.0, -1.0, 0.0), 0.44
STIFFNESS = np.array([1.0, 50.0, 1000.0, 20000.0] * 2)  # [N/m]
DAMPING = np.where(np.arange(8) < 4, 0.0, 1.4 * np.sqrt(STIFFNESS))  # damping ratio 0.7 of 1 kg [N s/m]
COUNT = len(STIFFNESS)
FRICTION = 0.3  # coefficient of the rough surfaces
SPURIOUS_MASS = 1.3e-4  # d/((1-d)Â), what the solver's softest contact adds at the tip [kg]
SOLVER = 2e-11  # relative error of the solver's forces, ten times the measured one


def planes(
    stiffness: Array,
    damping: Array,
    normal: tuple[float, float, float] = PLANE,
    offset: float = OFFSET,
) -> Surface:
    rows = len(stiffness)
    return Surface(stiffness, damping, np.tile(normal, (rows, 1)), np.full(rows, offset))


def world(surface: Surface, settings: PhysicsSettings, start: Array) -> Physics:
    """One simulation for each plane, at rest."""
    rows = len(surface.stiffness)
    physics = Physics(settings=settings, num_simulations=rows)
    physics.set_surface(np.arange(rows), surface)
    physics.reset(np.arange(rows), np.broadcast_to(start, (rows, 3)), np.zeros((rows, 3)))
    return physics


def compliance(q: Array, velocity: Array) -> Array:
    """τ = g + J_A^T (K_P x̃ - K_D J_A q̇), stationary where K_P x̃ = h_e."""
    J_A = ARM.analytical_jacobian(q)
    rate = np.einsum("nij,nj->ni", J_A, velocity)
    wrench = K_P * (TARGET - ARM.forward_kinematics(q)) - K_D * rate
    torque: Array = ARM.gravity_vector(q) + np.einsum("nij,ni->nj", J_A, wrench)
    return torque


def press(physics: Physics, milliseconds: int) -> None:
    """Closed loop of compliance control at 500 Hz."""
    for _ in range(milliseconds // 2):
        physics.set_torque(compliance(physics.joint_position, physics.joint_velocity))
        physics.advance(2)


def penetration(physics: Physics, surface: Surface) -> tuple[Array, Array]:
    """Depth [m] and its rate [m/s]."""
    depth = surface.offset - (surface.normal * physics.tip_position).sum(axis=-1)
    return depth, -(surface.normal * physics.tip_velocity).sum(axis=-1)


def pressure(physics: Physics, surface: Surface) -> Array:
    """The ideal spring and damper at the current state [N]."""
    depth, rate = penetration(physics, surface)
    force = np.maximum(0.0, surface.stiffness * depth + surface.damping * rate)
    return np.where(depth > 0.0, force, 0.0)


def pressure_with_spurious_mass(physics: Physics, surface: Surface) -> Array:
    """The same with the added mass, which feels the part J q̈ of the tip's acceleration [N]."""
    model = physics.model()
    inverse_weight = model.body_invweight0[model.body("link_3").id, 0]
    mass = 1e-4 / (1 - 1e-4) / inverse_weight
    assert mass == pytest.approx(SPURIOUS_MASS, rel=0.01)
    q, velocity = physics.joint_position, physics.joint_velocity
    q_acceleration = ARM.forward_dynamics(q, velocity, physics.torque, physics.contact_force)
    acceleration = np.einsum("nij,nj->ni", ARM.analytical_jacobian(q)[:, :3], q_acceleration)
    depth, rate = penetration(physics, surface)
    force = surface.stiffness * depth + surface.damping * rate
    force -= mass * (surface.normal * acceleration).sum(axis=-1)
    return np.where(depth > 0.0, np.maximum(0.0, force), 0.0)


def random_contacts(seed: int, rows: int, least: float, most: float) -> tuple[Physics, Surface]:
    """Simulations in motion, each with its own oblique plane at a random depth behind the tip."""
    generator = np.random.default_rng(seed)
    q = generator.uniform([-2.0, -0.3, -2.0], [2.0, 0.0, 2.0], size=(rows, 3))
    normal = generator.normal(size=(rows, 3))
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    depth = generator.uniform(least, most, size=rows)
    offset = (normal * ARM.forward_kinematics(q)[:, :3]).sum(axis=-1) + depth
    stiffness = 10.0 ** generator.uniform(0.0, 4.3, size=rows)
    surface = Surface(stiffness, generator.uniform(0.0, 1.4, rows) * np.sqrt(stiffness), normal, offset)
    physics = world(surface, PhysicsSettings(surface=True, joint_stops=False), np.zeros(3))
    physics.reset(np.arange(rows), q, generator.uniform(-0.5, 0.5, size=(rows, 3)))
    return physics, surface


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_static_press_balances_spring_against_spring(friction: float) -> None:
    surface = planes(STIFFNESS, DAMPING)
    physics = world(surface, PhysicsSettings(surface=True, surface_friction=friction), np.zeros(3))
    press(physics, 20_000)
    force, depth = physics.contact_force, penetration(physics, surface)[0]
    # the stiffest undamped plane still rings: 2e-6 of its force after 20 s
    np.testing.assert_allclose(force[:, 1], STIFFNESS * depth, rtol=1e-6)
    np.testing.assert_allclose(force[:, 1], STIFFNESS * K_P / (STIFFNESS + K_P) * 0.1, rtol=1e-5)
    # nothing pulls the tip along the surface, and friction between no forces is rounding
    np.testing.assert_allclose(force[:, [0, 2]], np.zeros((COUNT, 2)), rtol=0, atol=1e-7 if friction else 0)


def test_force_is_spring_and_damper_during_motion() -> None:
    surface = planes(STIFFNESS, DAMPING)
    physics = world(surface, PhysicsSettings(surface=True), np.zeros(3))
    touched, deviation = np.zeros(COUNT, dtype=np.int64), np.zeros(COUNT)
    for _ in range(1000):
        press(physics, 2)
        force = physics.contact_force[:, 1]
        expected = pressure_with_spurious_mass(physics, surface)
        np.testing.assert_allclose(force, expected, rtol=SOLVER, atol=SOLVER)
        deviation = np.maximum(deviation, np.abs(force - pressure(physics, surface)))
        touched += force > 0.0
    assert (touched > 100).all()
    # without the added mass: 1.3e-4 kg times tip accelerations of up to 80 m/s² on impact
    assert (deviation < 1.1e-2).all()


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_force_points_into_oblique_surfaces_in_the_world_frame(seed: int) -> None:
    physics, surface = random_contacts(seed, 100, 1e-3, 0.05)
    for _ in range(20):
        expected = -surface.normal * pressure_with_spurious_mass(physics, surface)[:, None]
        size = np.abs(expected).max(axis=-1, keepdims=True)
        # the plane's rotation matrix and back: rounding of unit vectors
        assert (np.abs(physics.contact_force - expected) <= SOLVER * (1.0 + size)).all()
        physics.advance(1)
    assert (np.abs(physics.contact_force).max(axis=-1) > 0.0).sum() > 50


def test_force_is_exactly_zero_without_contact() -> None:
    physics, surface = random_contacts(4, 200, -0.05, -1e-9)
    np.testing.assert_array_equal(physics.contact_force, np.zeros((200, 3)))
    physics.advance(40)
    free = penetration(physics, surface)[0] < 0.0
    assert 100 < free.sum() < 200  # some have meanwhile arrived
    np.testing.assert_array_equal(physics.contact_force[free], np.zeros((free.sum(), 3)))
    assert (np.abs(physics.contact_force[~free]).max(axis=-1) > 0.0).any()


def test_surface_never_pulls_on_a_tip_that_leaves() -> None:
    surface = planes(np.array([50.0, 1000.0]), np.array([100.0, 100.0]))
    physics = world(surface, PhysicsSettings(surface=True), np.zeros(3))
    velocity = np.tile([0.0, 1.0, 0.0], (2, 1))  # the slide runs out: y falls
    physics.reset(np.arange(2), np.tile([0.0, -0.12, 0.0], (2, 1)), velocity)
    for _ in range(15):
        depth, rate = penetration(physics, surface)
        assert (depth > 0.0).all()
        assert (surface.stiffness * depth + surface.damping * rate < -60.0).all()
        np.testing.assert_array_equal(physics.contact_force, np.zeros((2, 3)))
        physics.advance(1)


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_no_force_ever_points_out_of_the_surface(friction: float) -> None:
    surface = planes(STIFFNESS, 3 * DAMPING)
    settings = PhysicsSettings(surface=True, surface_friction=friction)
    physics = world(surface, settings, np.array([0.1, -0.05, -0.2]))
    left = np.zeros(COUNT, dtype=np.int64)
    for _ in range(1000):
        before = physics.contact_force[:, 1].copy()
        press(physics, 2)
        assert (physics.contact_force[:, 1] >= 0.0).all()
        left += (before > 0.0) & (physics.contact_force[:, 1] == 0.0)
    assert left.sum() >= 3


def test_momentum_balances_over_every_substep() -> None:
    rows = 60
    physics, _ = random_contacts(5, rows, 1e-3, 0.05)
    torque = np.random.default_rng(5).uniform(-2.0, 2.0, size=(rows, 3))
    physics.set_torque(torque)
    physics.advance(1)
    pressed = 0
    for _ in range(30):
        q, velocity = physics.joint_position.copy(), physics.joint_velocity.copy()
        force = physics.contact_force.copy()
        physics.advance(1)
        acceleration = (physics.joint_velocity - velocity) / physics.timestep
        # forces of up to 1e3 N with the solver's error; differences of velocities lose 3 digits of 16
        needed = ARM.inverse_dynamics(q, velocity, acceleration, force)
        np.testing.assert_allclose(needed, torque, rtol=0, atol=1e-9)
        pressed += int((np.abs(force).max(axis=-1) > 1.0).sum())
    assert pressed > 500


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_result_does_not_depend_on_how_often_it_is_read(friction: float) -> None:
    surface = planes(STIFFNESS, DAMPING)
    settings = PhysicsSettings(surface=True, surface_friction=friction)
    start, torque = np.array([0.1, -0.12, 0.1]), np.array([0.5, -4.0, 1.0])
    seldom, often = world(surface, settings, start), world(surface, settings, start)
    for factor in (1.0, -1.0, 0.5):
        for physics, calls in ((seldom, 1), (often, 20)):
            physics.set_torque(np.tile(factor * torque, (COUNT, 1)))
            for _ in range(calls):
                physics.advance(20 // calls)
        np.testing.assert_array_equal(seldom.measurement, often.measurement)
        np.testing.assert_array_equal(seldom.contact_force, often.contact_force)
        assert (seldom.contact_force[:, 1] > 0.0).any()


def test_new_surface_acts_at_the_next_advance_and_keeps_the_state() -> None:
    first = planes(STIFFNESS, DAMPING)
    physics = world(first, PhysicsSettings(surface=True), np.array([0.0, -0.12, 0.0]))
    press(physics, 100)
    q, others = physics.joint_position.copy(), physics.contact_force[[0, 1, 3, 4, 6, 7]].copy()
    second = planes(np.array([700.0, 300.0]), np.array([5.0, 0.0]), (1.0, -2.0, 0.5), 0.9)
    physics.set_surface(np.array([2, 5]), second)
    np.testing.assert_array_equal(physics.joint_position, q)
    np.testing.assert_array_equal(physics.contact_force[[0, 1, 3, 4, 6, 7]], others)
    physics.advance(1)
    arrays = {name: np.array(getattr(first, name)) for name in ("stiffness", "damping", "normal", "offset")}
    for name, values in arrays.items():
        values[[2, 5]] = getattr(second, name)
    both = Surface(**arrays)
    expected = -both.normal * pressure_with_spurious_mass(physics, both)[:, None]
    np.testing.assert_allclose(physics.contact_force, expected, rtol=SOLVER, atol=SOLVER)
    assert (expected[[2, 5], 0] < -1.0).all()


@pytest.mark.parametrize("factors", [(0.7, 0.7, 0.7), (1.3, 1.3, 1.3), (0.7, 1.3, 0.7)])
def test_surface_stays_calibrated_on_an_arm_of_other_masses(factors: tuple[float, float, float]) -> None:
    surface = planes(STIFFNESS[4:], DAMPING[4:])
    physics = Physics(settings=PhysicsSettings(surface=True), num_simulations=4)
    ids = np.arange(4)
    physics.set_dynamics(ids, np.tile(factors, (4, 1)), np.zeros((4, 3)), np.zeros((4, 3)))
    physics.set_surface(ids, surface)
    physics.reset(ids, np.zeros((4, 3)), np.zeros((4, 3)))
    press(physics, 8_000)
    depth = penetration(physics, surface)[0]
    assert (depth > 1e-4).all()
    # what is left of the motion after 8 s
    np.testing.assert_allclose(physics.contact_force[:, 1], surface.stiffness * depth, rtol=1e-6)


@pytest.mark.parametrize("stops", [True, False])
def test_world_without_surface_has_no_contact_force_and_takes_no_surface(stops: bool) -> None:
    physics = Physics(settings=PhysicsSettings(joint_stops=stops))
    physics.reset(np.arange(1), np.array([[0.0, 0.0, -1.5]]), np.zeros((1, 3)))  # below the floor
    np.testing.assert_array_equal(physics.contact_force, np.zeros((1, 3)))
    with pytest.raises(InvalidValueError, match="without a surface"):
        physics.set_surface(np.arange(1), Surface.single(50.0, PLANE, OFFSET))


def sliding(stiffness: Array, damping: Array) -> tuple[Array, Array, Array]:
    """Forces (t, n, 3), tip velocities (t, n, 3) and ideal pressures (t, n) of dragged tips."""
    surface = planes(stiffness, damping)
    settings = PhysicsSettings(surface=True, surface_friction=FRICTION)
    physics = world(surface, settings, np.array([0.0, -0.11, 0.0]))
    rows = []
    for _ in range(300):
        q, velocity = physics.joint_position, physics.joint_velocity
        physics.set_torque(compliance(q, velocity) + np.array([0.0, 0.0, 6.0]))  # lifts the third link
        physics.advance(1)
        rows.append((physics.contact_force.copy(), physics.tip_velocity.copy(), pressure(physics, surface)))
    force, tip_velocity, ideal = (np.array(values) for values in zip(*rows, strict=True))
    return force, tip_velocity, ideal


def test_tangential_force_stays_in_the_friction_cone_and_drags_the_surface_along() -> None:
    force, velocity, _ = sliding(np.array([50.0, 1000.0]), np.array([20.0, 100.0]))
    normal, tangential = force[..., 1], force[..., [0, 2]]
    size = np.linalg.norm(tangential, axis=-1)
    # the solver projects onto the cone: rounding
    assert (size <= FRICTION * normal * (1 + 1e-9)).all()
    assert (size > 0.5 * FRICTION * normal)[normal > 0.1].any(axis=0)
    assert ((tangential * velocity[..., [0, 2]]).sum(axis=-1) >= 0.0).all()


@pytest.mark.parametrize("damping", [0.0, 20.0])
def test_sliding_friction_is_the_coefficient_times_the_normal_force(damping: float) -> None:
    force, velocity, _ = sliding(np.array([50.0, 1000.0]), np.full(2, damping))
    fast = np.linalg.norm(velocity[..., [0, 2]], axis=-1) > 0.1
    size = np.linalg.norm(force[..., [0, 2]], axis=-1)
    assert fast.sum() > 100
    # Coulomb's law, at speeds well above those of the regularised friction model's creep
    np.testing.assert_allclose(size[fast], FRICTION * force[fast, 1], rtol=0.02)


def test_friction_leaves_the_normal_force_alone() -> None:
    force, _, ideal = sliding(np.array([50.0, 1000.0]), np.array([20.0, 100.0]))
    # a tenth of the friction force itself would already be a coupling
    np.testing.assert_allclose(force[..., 1], ideal, rtol=0.01, atol=0.03)
