"""Simulations: right against theory, current, reproducible to the last bit, independent of each other."""

import copy
import pickle
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from prp_gym.errors import InvalidValueError, NonFiniteError
from prp_gym.physics import Physics, PhysicsSettings, Surface
from prp_gym.robot import NOMINAL, PRPArm
from tests.support.pinocchio_model import Array, PinocchioArm

Rows = NDArray[np.intp]

ARM = PRPArm()
FREE = PhysicsSettings(joint_stops=False)
CONTACT = PhysicsSettings(surface=True)
ROUGH = PhysicsSettings(surface=True, surface_friction=0.3)
WORLDS = {"free": FREE, "stops": PhysicsSettings(), "contact": CONTACT, "rough contact": ROUGH}
ROWS = 132  # of the table of random simulations below; from 128 on they are stored in another way
ONE = np.arange(1)
GENERATOR = np.random.default_rng(0)
START = GENERATOR.uniform([-2.0, -0.3, -2.0], [2.0, 0.0, 2.0], size=(ROWS, 3))
SPEED = GENERATOR.uniform(-2.0, 2.0, size=(ROWS, 3))
TORQUE = GENERATOR.uniform(-8.0, 8.0, size=(20, ROWS, 3))
NORMAL = GENERATOR.normal(size=(ROWS, 3))
NORMAL /= np.linalg.norm(NORMAL, axis=-1, keepdims=True)
OFFSET = (NORMAL * ARM.forward_kinematics(START)[:, :3]).sum(axis=-1) + GENERATOR.uniform(0.0, 0.03, ROWS)
STIFFNESS = 10.0 ** GENERATOR.uniform(1.7, 3.7, size=ROWS)
MASS_FACTOR = GENERATOR.uniform(0.7, 1.3, size=(ROWS, 3))
VISCOUS, COULOMB = GENERATOR.uniform(0.0, 0.3, size=(2, ROWS, 3))
ROUNDING = 1e-14  # of positions, lengths and angles


@pytest.fixture(params=list(WORLDS))
def settings(request: pytest.FixtureRequest) -> PhysicsSettings:
    return WORLDS[str(request.param)]


def simulations(settings: PhysicsSettings, rows: Rows, threads: int = 1) -> Physics:
    """Some rows of the table, each with its own masses, friction, surface and state of motion."""
    physics = Physics(NOMINAL, settings, len(rows), threads)
    ids = np.arange(len(rows))
    physics.set_dynamics(ids, MASS_FACTOR[rows], VISCOUS[rows], COULOMB[rows])
    if settings.surface:
        physics.set_surface(ids, surface_of(rows))
    physics.reset(ids, START[rows], SPEED[rows])
    return physics


def surface_of(rows: Rows) -> Surface:
    return Surface(STIFFNESS[rows], 0.02 * STIFFNESS[rows], NORMAL[rows], OFFSET[rows])


def answers(physics: Physics) -> Array:
    """All that the simulations say, one row each."""
    parts = (physics.measurement, physics.contact_force, physics.torque, physics.joints_at_stop)
    return np.concatenate(parts, axis=-1)


def run(physics: Physics, rows: Rows, calls: range = range(20)) -> Array:
    """Answers (calls, n, ...) under the table's torques, 10 substeps each."""
    history = []
    for call in calls:
        physics.set_torque(TORQUE[call % len(TORQUE), rows])
        physics.advance(10)
        history.append(answers(physics))
    return np.array(history)


@pytest.mark.parametrize(
    ("start", "speed"),
    [((0, 0, 0), (0, 0, 0)), ((0.3, -0.1, -0.5), (1, 0.5, -2)), ((0.3, -0.2, 2), (0.5, 0.1, 1))],
)
def test_free_swing_is_pinocchios_with_the_same_integrator(
    start: tuple[float, float, float], speed: tuple[float, float, float]
) -> None:
    oracle, physics, none = PinocchioArm(), Physics(settings=FREE), np.zeros(3)
    q, velocity = np.array(start, dtype=np.float64), np.array(speed, dtype=np.float64)
    physics.reset(ONE, q[None], velocity[None])
    for _ in range(5000):
        velocity = velocity + 1e-3 * oracle.forward_dynamics(q, velocity, none, none)
        q = q + 1e-3 * velocity
        physics.advance(1)
        # rounding of 1e-15 a step, carried along for 5000 steps: 2e-12 measured
        np.testing.assert_allclose(physics.joint_position[0], q, rtol=0, atol=1e-10)
        np.testing.assert_allclose(physics.joint_velocity[0], velocity, rtol=0, atol=1e-10)


def test_measurement_is_the_kinematics_of_the_current_joint_state(settings: PhysicsSettings) -> None:
    rows = np.arange(30)
    physics = simulations(settings, rows)
    for call in range(5):
        measurement = physics.measurement
        assert measurement.shape == (30, physics.measurement_size)
        q, velocity = measurement[:, 0:3], measurement[:, 3:6]
        state = [physics.data(row) for row in range(30)]
        np.testing.assert_array_equal(q, [data.qpos for data in state])
        np.testing.assert_array_equal(velocity, [data.qvel for data in state])
        np.testing.assert_allclose(measurement[:, 6:12], ARM.forward_kinematics(q), rtol=0, atol=ROUNDING)
        rate = np.einsum("nij,nj->ni", ARM.analytical_jacobian(q), velocity)
        # speeds of up to 30
        np.testing.assert_allclose(measurement[:, 12:18], rate, rtol=0, atol=30 * ROUNDING)
        run(physics, rows, range(call, call + 1))
    assert np.abs(physics.joint_position - START[rows]).max() > 0.05


def test_named_answers_are_parts_of_the_measurement() -> None:
    physics = simulations(CONTACT, np.arange(5))
    run(physics, np.arange(5), range(3))
    measurement = physics.measurement
    np.testing.assert_array_equal(physics.joint_position, measurement[:, 0:3])
    np.testing.assert_array_equal(physics.joint_velocity, measurement[:, 3:6])
    np.testing.assert_array_equal(physics.tip_position, measurement[:, 6:9])
    np.testing.assert_array_equal(physics.tip_velocity, measurement[:, 12:15])
    np.testing.assert_array_equal(physics.contact_force, measurement[:, 18:21])
    assert measurement[:, 18:21].any()
    np.testing.assert_array_equal(physics.torque, TORQUE[2, :5])
    written = np.empty((5, physics.measurement_size))
    physics.measure(written)
    np.testing.assert_array_equal(written, measurement)
    for answer in (
        physics.joint_position,
        physics.joint_velocity,
        physics.tip_position,
        physics.contact_force,
    ):
        with pytest.raises(ValueError, match="read-only"):
            answer[0, 0] = 1.0


def test_many_substeps_at_once_are_many_single_ones(settings: PhysicsSettings) -> None:
    rows = np.arange(20)
    at_once, singly = simulations(settings, rows), simulations(settings, rows)
    for call in range(10):
        for physics in (at_once, singly):
            physics.set_torque(TORQUE[call, rows])
        at_once.advance(25)
        for _ in range(25):
            singly.advance(1)
        np.testing.assert_array_equal(answers(at_once), answers(singly))


@pytest.mark.parametrize("threads", [1, 2, 0])
def test_a_simulation_among_five_is_the_simulation_alone(settings: PhysicsSettings, threads: int) -> None:
    together = run(simulations(settings, np.arange(5), threads), np.arange(5))
    assert (together[..., 18:21] != 0.0).any() == settings.surface
    assert (together[..., -3:] != 0.0).any() == settings.joint_stops
    for row in range(5):
        alone = run(simulations(settings, np.array([row])), np.array([row]))
        np.testing.assert_array_equal(together[:, row], alone[:, 0])


@pytest.mark.parametrize("threads", [1, 2])
def test_a_simulation_among_more_than_a_hundred_is_the_simulation_alone(
    settings: PhysicsSettings, threads: int
) -> None:
    rows = np.arange(ROWS)
    together = run(simulations(settings, rows, threads), rows)
    for row in (0, 1, 63, 128, 131):
        alone = run(simulations(settings, np.array([row])), np.array([row]))
        np.testing.assert_array_equal(together[:, row], alone[:, 0])


@pytest.mark.parametrize("count", [6, ROWS])
def test_reset_of_some_leaves_the_others_bits_alone(settings: PhysicsSettings, count: int) -> None:
    rows, chosen = np.arange(count), np.array([1, 4])
    others = np.setdiff1d(rows, chosen)
    disturbed, within_limits = simulations(settings, rows), simulations(settings, rows)
    for physics in (disturbed, within_limits):
        run(physics, rows, range(5))
    before = answers(disturbed)
    disturbed.reset(chosen, START[chosen], SPEED[chosen])
    np.testing.assert_array_equal(answers(disturbed)[others], before[others])
    np.testing.assert_array_equal(disturbed.joint_position[chosen], START[chosen])
    np.testing.assert_array_equal(disturbed.torque[chosen], np.zeros((2, 3)))
    after, expected = run(disturbed, rows), run(within_limits, rows)
    np.testing.assert_array_equal(after[:, others], expected[:, others])
    assert (after[:, chosen] != expected[:, chosen]).any()


@pytest.mark.parametrize("count", [5, ROWS])
def test_reset_forgets_everything_that_came_before(settings: PhysicsSettings, count: int) -> None:
    rows = np.arange(count)
    fresh, used = simulations(settings, rows), simulations(settings, rows)
    run(used, rows)
    used.reset(rows, START[rows], SPEED[rows])
    np.testing.assert_array_equal(answers(used), answers(fresh))
    np.testing.assert_array_equal(run(used, rows), run(fresh, rows))


def clone_by_restore(physics: Physics) -> Physics:
    fresh = Physics(physics.parameters, physics.settings, physics.num_simulations)
    fresh.restore(physics.snapshot())
    return fresh


def clone_by_pickle(physics: Physics) -> Physics:
    loaded: Physics = pickle.loads(pickle.dumps(physics))
    return loaded


CLONES = {"restore": clone_by_restore, "pickle": clone_by_pickle, "deepcopy": copy.deepcopy}


@pytest.mark.parametrize("clone", CLONES.values(), ids=list(CLONES))
@pytest.mark.parametrize("count", [5, ROWS])
def test_a_copy_goes_on_bit_for_bit(
    settings: PhysicsSettings, clone: Callable[[Physics], Physics], count: int
) -> None:
    rows = np.arange(count)
    physics = simulations(settings, rows)
    run(physics, rows, range(7))
    twin = clone(physics)
    np.testing.assert_array_equal(answers(twin), answers(physics))
    np.testing.assert_array_equal(run(twin, rows), run(physics, rows))


def test_restore_undoes_everything_since_the_snapshot(settings: PhysicsSettings) -> None:
    rows = np.arange(8)
    physics = simulations(settings, rows)
    run(physics, rows, range(7))
    state, at_snapshot = physics.snapshot(), answers(physics)
    expected = run(physics, rows)
    physics.set_dynamics(rows, MASS_FACTOR[rows + 8], VISCOUS[rows + 8], COULOMB[rows + 8])
    if settings.surface:
        physics.set_surface(rows, surface_of(rows + 8))
    physics.reset(rows, START[rows + 8], SPEED[rows + 8])
    assert (run(physics, rows) != expected).any()
    physics.restore(state)
    np.testing.assert_array_equal(answers(physics), at_snapshot)
    np.testing.assert_array_equal(run(physics, rows), expected)


@pytest.mark.parametrize("change", ["surface", "dynamics"])
def test_restore_undoes_the_first_change_of_the_model_too(change: str) -> None:
    rows = np.arange(3)
    physics = Physics(settings=CONTACT, num_simulations=3)
    physics.reset(rows, START[rows], SPEED[rows])
    state = physics.snapshot()
    expected = run(physics, rows)
    if change == "surface":
        physics.set_surface(rows, surface_of(rows))
    else:
        physics.set_dynamics(rows, MASS_FACTOR[rows], VISCOUS[rows], COULOMB[rows])
    physics.restore(state)
    np.testing.assert_array_equal(run(physics, rows), expected)


def test_restore_wants_a_snapshot_of_as_many_simulations() -> None:
    with pytest.raises(InvalidValueError, match="snapshot"):
        Physics(num_simulations=2).restore(Physics(num_simulations=3).snapshot())


def test_set_dynamics_is_the_arm_of_scaled_parameters() -> None:
    ids, chosen = np.arange(6), np.array([1, 2, 5])
    physics, untouched = (Physics(settings=FREE, num_simulations=6) for _ in range(2))
    physics.set_dynamics(chosen, MASS_FACTOR[chosen], VISCOUS[chosen], COULOMB[chosen])
    for each in (physics, untouched):
        each.reset(ids, START[ids], SPEED[ids])
        each.advance(1000)
    np.testing.assert_array_equal(physics.measurement[[0, 3, 4]], untouched.measurement[[0, 3, 4]])
    for row in chosen:
        scaled = NOMINAL.scaled(MASS_FACTOR[row])
        viscous, coulomb = (tuple(values[row].tolist()) for values in (VISCOUS, COULOMB))
        alone = Physics(replace(scaled, viscous_friction=viscous, coulomb_friction=coulomb), FREE)
        alone.reset(ONE, START[[row]], SPEED[[row]])
        alone.advance(1000)
        # masses that differ by rounding, over 1 s
        np.testing.assert_allclose(physics.measurement[row], alone.measurement[0], rtol=0, atol=1e-10)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
@pytest.mark.parametrize("what", ["joint_position", "joint_velocity"])
def test_reset_to_a_state_that_is_not_finite_changes_nothing(what: str, bad: float) -> None:
    rows = np.arange(4)
    physics, undisturbed = simulations(CONTACT, rows), simulations(CONTACT, rows)
    for each in (physics, undisturbed):
        run(each, rows, range(3))
    state = {"joint_position": START[:2].copy(), "joint_velocity": SPEED[:2].copy()}
    state[what][1, 2] = bad
    with pytest.raises(NonFiniteError, match=what):
        physics.reset(np.array([0, 2]), **state)
    np.testing.assert_array_equal(answers(physics), answers(undisturbed))
    np.testing.assert_array_equal(run(physics, rows), run(undisturbed, rows))


@pytest.mark.parametrize("count", [0, -1])
def test_there_must_be_a_simulation(count: int) -> None:
    with pytest.raises(InvalidValueError, match="num_simulations"):
        Physics(num_simulations=count)
