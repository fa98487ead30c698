"""Simulations of the link: exactly I q̈ + F q̇ + G sin q = τ, each with its own numbers, reproducible."""

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from prp_gym.physics import LinkPhysics, link_to_mjcf
from prp_gym.physics.scene import FIXED_CAMERAS, FLOOR_HEIGHT
from prp_gym.robot import NOMINAL_LINK, Link, LinkParameters
from tests.support.pinocchio_model import Array

# isort: split
import mujoco  # after prp_gym, which chooses how MuJoCo draws

Rows = NDArray[np.intp]

ROWS = 200  # of the table of random simulations below
ONE = np.arange(1)
GENERATOR = np.random.default_rng(0)
START, SPEED = GENERATOR.uniform(-3.0, 3.0, size=(2, ROWS, 1))
TORQUE = GENERATOR.uniform(-5.0, 5.0, size=(20, ROWS, 1))
INERTIA = 10.0 ** GENERATOR.uniform(-2.0, 1.0, ROWS)
FRICTION, MOMENT = GENERATOR.uniform(0.0, 1.0, ROWS), GENERATOR.uniform(0.0, 5.0, ROWS)
FRICTION[::5], MOMENT[::7] = 0.0, 0.0
STEP = 1e-3  # [s]
HEIGHT, LENGTH = 0.35, 0.3  # of the joint's axis, and of the link [m]
FREE = replace(NOMINAL_LINK, viscous_friction=0.0)
WORLDS = {
    "report": NOMINAL_LINK,
    "frictionless": FREE,
    "weightless": replace(NOMINAL_LINK, gravity_moment=0.0),
    "light and unbalanced": LinkParameters(inertia=0.02, viscous_friction=0.3, gravity_moment=4.0),
}


def recursion(q: Array, velocity: Array, torque: Array, numbers: tuple[Array, Array, Array]) -> Array:
    """(2, ...) state after one step that is implicit in the friction and semi-implicit in the position."""
    inertia, friction, moment = numbers
    velocity = (inertia * velocity + STEP * (torque - moment * np.sin(q))) / (inertia + STEP * friction)
    return np.stack([q + STEP * velocity, velocity])


def simulations(rows: Rows, threads: int = 1) -> LinkPhysics:
    """Some rows of the table, each with its own link and state of motion."""
    physics = LinkPhysics(num_simulations=len(rows), num_threads=threads)
    ids = np.arange(len(rows))
    physics.set_parameters(ids, INERTIA[rows], FRICTION[rows], MOMENT[rows])
    physics.reset(ids, START[rows], SPEED[rows])
    return physics


def answers(physics: LinkPhysics) -> Array:
    """All that the simulations say, one row each."""
    return np.concatenate([physics.measurement, physics.tip_position, physics.torque], axis=-1)


def run(physics: LinkPhysics, rows: Rows, calls: range = range(20)) -> Array:
    """Answers (calls, n, ...) under the table's torques, 10 substeps each."""
    history = []
    for call in calls:
        physics.set_torque(TORQUE[call % len(TORQUE), rows])
        physics.advance(10)
        history.append(answers(physics))
    return np.array(history)


@pytest.mark.parametrize("parameters", WORLDS.values(), ids=list(WORLDS))
def test_motion_is_the_equations_with_the_same_integrator(parameters: LinkParameters) -> None:
    physics, count = LinkPhysics(parameters, num_simulations=30), 30
    physics.reset(np.arange(count), START[:count], SPEED[:count])
    I, F, G = Link(parameters).parameter_vector()  # noqa: E741
    q, velocity = START[:count], SPEED[:count]
    for step in range(3000):
        torque = TORQUE[step % 20, :count]
        physics.set_torque(torque)
        physics.advance(1)
        q, velocity = recursion(q, velocity, torque, (I, F, G))
        # rounding of 1e-15 a step, carried along for 3000 steps at up to 60 rad: 4e-12 measured
        np.testing.assert_allclose(physics.joint_position, q, rtol=0, atol=1e-10)
        np.testing.assert_allclose(physics.joint_velocity, velocity, rtol=0, atol=1e-10)


def test_each_simulation_moves_by_its_own_parameters() -> None:
    rows = np.arange(ROWS)
    physics, q, velocity = simulations(rows), START, SPEED
    numbers = (INERTIA[:, None], FRICTION[:, None], MOMENT[:, None])
    for call in range(20):
        physics.set_torque(TORQUE[call])
        physics.advance(10)
        for _ in range(10):
            q, velocity = recursion(q, velocity, TORQUE[call], numbers)
    # 200 roundings; the lightest links reach 100 rad/s
    np.testing.assert_allclose(physics.joint_velocity, velocity, rtol=1e-11, atol=1e-11)
    np.testing.assert_allclose(physics.joint_position, q, rtol=1e-11, atol=1e-11)


@pytest.mark.parametrize("parameters", WORLDS.values(), ids=list(WORLDS))
def test_compiled_model_is_the_closed_form(parameters: LinkParameters) -> None:
    physics, link = LinkPhysics(parameters, num_simulations=20), Link(parameters)
    q, velocity = START[:20], SPEED[:20]
    physics.reset(np.arange(20), q, velocity)
    for row in range(20):
        model, data, full = physics.model(row), physics.data(row), np.empty((1, 1))
        mujoco.mj_fullM(model, data, full)
        mujoco.mj_energyPos(model, data)
        mujoco.mj_energyVel(model, data)
        # a dozen operations on numbers of order one to ten
        np.testing.assert_allclose(full, link.inertia_matrix(q[row]), rtol=1e-14)
        np.testing.assert_allclose(data.qfrc_bias, link.gravity_vector(q[row]), rtol=0, atol=2e-14)
        np.testing.assert_allclose(data.qfrc_passive, -link.friction_force(velocity[row]), rtol=1e-14)
        hanging = -parameters.gravity_moment + 9.81 * model.body_mass[1] * HEIGHT  # about the world's origin
        energy = [link.potential_energy(q[row]) + hanging, link.kinetic_energy(q[row], velocity[row])]
        np.testing.assert_allclose(data.energy, energy, rtol=1e-13, atol=1e-13)


@pytest.mark.parametrize(("inertia", "moment"), [(0.5, 1.85), (0.1, 1.85), (2.0, 0.5)])
def test_small_oscillation_has_the_period_of_the_pendulum(inertia: float, moment: float) -> None:
    physics = LinkPhysics(LinkParameters(inertia, 0.0, moment))
    physics.reset(ONE, np.array([[0.01]]), np.zeros((1, 1)))
    period = 2 * math.pi * math.sqrt(inertia / moment)
    crossings: list[float] = []
    for step in range(round(3.2 * period / STEP)):
        before = float(physics.joint_position[0, 0])
        physics.advance(1)
        after = float(physics.joint_position[0, 0])
        if before < 0.0 <= after:
            crossings.append((step + before / (before - after)) * STEP)
    assert len(crossings) == 3
    # an amplitude of 0.01 rad lengthens it by 6e-6, the step of 1 ms shortens it by up to (ωh)²/24 = 1e-6
    assert np.diff(crossings) == pytest.approx([period, period], rel=1e-5)


def test_damped_oscillation_decays_as_theory_says() -> None:
    physics, link = LinkPhysics(), NOMINAL_LINK
    physics.reset(ONE, np.array([[0.01]]), np.zeros((1, 1)))
    decay = link.viscous_friction / (2 * link.inertia)
    frequency = math.sqrt(link.gravity_moment / link.inertia - decay**2)
    for step in range(1, 5001):
        physics.advance(1)
        time = step * STEP
        wave = math.cos(frequency * time) + decay / frequency * math.sin(frequency * time)
        # first order in the step: half a step's travel at 0.02 rad/s
        assert physics.joint_position[0, 0] == pytest.approx(
            0.01 * math.exp(-decay * time) * wave, rel=0, abs=1.1e-5
        )


def test_energy_is_kept_without_friction_and_torque() -> None:
    link, physics = Link(FREE), LinkPhysics(FREE, num_simulations=20)
    physics.reset(np.arange(20), START[:20], SPEED[:20])

    def energy() -> Array:
        q, velocity = physics.joint_position, physics.joint_velocity
        return link.kinetic_energy(q, velocity) + link.potential_energy(q)

    before, largest = energy(), np.zeros(20)
    for _ in range(1000):
        physics.advance(10)
        largest = np.maximum(largest, np.abs(energy() - before))
    # the integrator is symplectic: its energy swings with h/2 G q̇ sin q, up to 5 mJ here, and never drifts
    assert (largest < 6e-3).all()
    assert largest.max() > 1e-4


def test_friction_takes_the_energy_of_its_equation() -> None:
    link, physics = Link(), LinkPhysics()
    physics.reset(ONE, np.array([[2.0]]), np.array([[3.0]]))

    def energy() -> float:
        q, velocity = physics.joint_position, physics.joint_velocity
        return float((link.kinetic_energy(q, velocity) + link.potential_energy(q))[0])

    before, spent = energy(), 0.0
    for _ in range(5000):
        speed = float(physics.joint_velocity[0, 0])
        physics.advance(1)
        speed = (speed + float(physics.joint_velocity[0, 0])) / 2
        spent += STEP * 0.15 * speed**2
    assert spent > 2.0
    # the integrator's own exchange of up to 5 mJ, as above
    assert before - energy() == pytest.approx(spent, abs=6e-3)


def test_tip_swings_on_a_circle_above_the_floor_and_q_0_hangs_down() -> None:
    physics = LinkPhysics(num_simulations=4)
    q = np.array([[0.0], [math.pi / 2], [math.pi], [-0.7]])
    physics.reset(np.arange(4), q, np.zeros((4, 1)))
    expected = np.hstack([LENGTH * np.sin(q), np.zeros((4, 1)), HEIGHT - LENGTH * np.cos(q)])
    # sums of lengths below one
    np.testing.assert_allclose(physics.tip_position, expected, rtol=0, atol=1e-15)
    assert physics.tip_position[:, 2].min() > FLOOR_HEIGHT + 0.02  # the tip's radius


def test_measurement_is_the_joint_state() -> None:
    physics = simulations(np.arange(5))
    run(physics, np.arange(5), range(3))
    assert (physics.joint_count, physics.measurement_size) == (1, 2)
    np.testing.assert_array_equal(physics.measurement[:, :1], physics.joint_position)
    np.testing.assert_array_equal(physics.measurement[:, 1:], physics.joint_velocity)
    np.testing.assert_array_equal([physics.data(row).qpos for row in range(5)], physics.joint_position)
    np.testing.assert_array_equal([physics.data(row).qvel for row in range(5)], physics.joint_velocity)
    np.testing.assert_array_equal(physics.torque, TORQUE[2, :5])
    written = np.empty((5, 2))
    physics.measure(written)
    np.testing.assert_array_equal(written, physics.measurement)


def test_link_has_no_stops_and_touches_nothing() -> None:
    physics = LinkPhysics(num_simulations=2)
    physics.reset(np.arange(2), np.array([[0.0], [9.0]]), np.array([[20.0], [-20.0]]))
    physics.advance(1000)
    assert (np.abs(physics.joint_position) > math.pi).all()
    np.testing.assert_array_equal(physics.stop_violation, np.zeros((2, 1)))
    np.testing.assert_array_equal(physics.joints_at_stop, np.zeros((2, 1), dtype=bool))
    np.testing.assert_array_equal(physics.contact_force, np.zeros((2, 3)))
    for answer in (physics.stop_violation, physics.contact_force, physics.torque, physics.joint_position):
        with pytest.raises(ValueError, match="read-only"):
            answer[0, 0] = 1.0


def test_torque_has_no_limit_of_its_own() -> None:
    physics = LinkPhysics(replace(FREE, gravity_moment=0.0))
    physics.reset(ONE, np.zeros((1, 1)), np.zeros((1, 1)))
    physics.set_torque(np.array([[1e4]]))
    physics.advance(1)
    # 1e4 N m on 0.5 kg m² over 1 ms
    assert physics.joint_velocity[0, 0] == pytest.approx(20.0, rel=1e-14)


def test_document_names_what_the_arms_does_and_survives_export() -> None:
    text = link_to_mjcf(LinkParameters(1 / 3, 1 / 7, 5 / 3), 0.0025)
    exported = mujoco.MjSpec.from_string(text).to_xml()
    for document in (text, exported):
        model = mujoco.MjModel.from_xml_string(document)
        assert (model.nbody, model.nv, model.nu, model.npair) == (2, 1, 1, 0)
        assert {model.body(1).name, model.site(0).name, model.joint(0).name} == {"link_1", "tip", "joint_1"}
        assert tuple(model.camera(index).name for index in range(model.ncam)) == FIXED_CAMERAS
        for name in ("jnt_limited", "actuator_ctrllimited", "geom_contype", "geom_conaffinity"):
            assert not getattr(model, name).any(), name
        assert model.opt.timestep == 0.0025
        assert int(model.opt.integrator) == int(mujoco.mjtIntegrator.mjINT_EULER)
    assert link_to_mjcf() == link_to_mjcf(NOMINAL_LINK, 0.001)
