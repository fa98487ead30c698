"""Batches of links: reproducible to the last bit, independent of each other, each with its own parameters."""

import copy
import math
import pickle
from collections.abc import Callable

import numpy as np
import pytest

from prp_gym.errors import InvalidValueError, NonFiniteError, ShapeError
from prp_gym.physics import LinkPhysics, Physics
from prp_gym.robot import LinkParameters
from tests.physics.test_link_physics import (
    FRICTION,
    INERTIA,
    MOMENT,
    ONE,
    ROWS,
    SPEED,
    START,
    TORQUE,
    WORLDS,
    answers,
    run,
    simulations,
)


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("count", [5, ROWS])
def test_a_simulation_among_many_is_the_simulation_alone(count: int, threads: int) -> None:
    rows = np.arange(count)
    together = run(simulations(rows, threads), rows)
    for row in (0, 1, count // 2, count - 1):
        alone = run(simulations(np.array([row])), np.array([row]))
        np.testing.assert_array_equal(together[:, row], alone[:, 0])


def test_many_substeps_at_once_are_many_single_ones() -> None:
    rows = np.arange(20)
    at_once, singly = simulations(rows), simulations(rows)
    for physics, calls in ((at_once, 1), (singly, 25)):
        physics.set_torque(TORQUE[0, rows])
        for _ in range(calls):
            physics.advance(25 // calls)
    np.testing.assert_array_equal(answers(at_once), answers(singly))


def test_reset_of_some_leaves_the_others_bits_alone() -> None:
    rows, chosen = np.arange(8), np.array([1, 4])
    disturbed, within_limits = simulations(rows), simulations(rows)
    for physics in (disturbed, within_limits):
        run(physics, rows, range(5))
    disturbed.reset(chosen, START[chosen], SPEED[chosen])
    np.testing.assert_array_equal(disturbed.joint_position[chosen], START[chosen])
    np.testing.assert_array_equal(disturbed.torque[chosen], np.zeros((2, 1)))
    others = np.setdiff1d(rows, chosen)
    after, expected = run(disturbed, rows), run(within_limits, rows)
    np.testing.assert_array_equal(after[:, others], expected[:, others])
    assert (after[:, chosen] != expected[:, chosen]).any()


@pytest.mark.parametrize("base", WORLDS.values(), ids=list(WORLDS))
def test_set_parameters_gives_the_link_made_with_them(base: LinkParameters) -> None:
    ids, chosen = np.arange(6), np.array([1, 3, 5])
    physics, untouched = (LinkPhysics(base, num_simulations=6) for _ in range(2))
    physics.set_parameters(chosen, INERTIA[chosen], FRICTION[chosen], MOMENT[chosen])
    for each in (physics, untouched):
        each.reset(ids, START[ids], SPEED[ids])
        each.advance(1000)
    np.testing.assert_array_equal(physics.measurement[[0, 2, 4]], untouched.measurement[[0, 2, 4]])
    for row in chosen:
        own = LinkParameters(float(INERTIA[row]), float(FRICTION[row]), float(MOMENT[row]))
        alone = LinkPhysics(own)
        alone.reset(ONE, START[[row]], SPEED[[row]])
        alone.advance(1000)
        np.testing.assert_array_equal(physics.measurement[row], alone.measurement[0])
        for name in ("body_mass", "body_inertia", "body_ipos", "dof_damping", "dof_M0", "body_subtreemass"):
            mine, model = getattr(physics.model(int(row)), name), getattr(alone.model(), name)
            # inertias about the axis are recomputed in another order
            np.testing.assert_allclose(mine, model, rtol=1e-14, err_msg=name)


def clone_by_restore(physics: LinkPhysics) -> LinkPhysics:
    fresh = LinkPhysics(physics.parameters, physics.timestep, physics.num_simulations)
    fresh.restore(physics.snapshot())
    return fresh


def clone_by_pickle(physics: LinkPhysics) -> LinkPhysics:
    loaded: LinkPhysics = pickle.loads(pickle.dumps(physics))
    return loaded


CLONES = {"restore": clone_by_restore, "pickle": clone_by_pickle, "deepcopy": copy.deepcopy}


@pytest.mark.parametrize("clone", CLONES.values(), ids=list(CLONES))
@pytest.mark.parametrize("count", [5, ROWS])
def test_a_copy_goes_on_bit_for_bit(clone: Callable[[LinkPhysics], LinkPhysics], count: int) -> None:
    rows = np.arange(count)
    physics = LinkPhysics(WORLDS["light and unbalanced"], 0.002, count, 2)
    physics.set_parameters(rows[1:], INERTIA[rows[1:]], FRICTION[rows[1:]], MOMENT[rows[1:]])
    physics.reset(rows, START[rows], SPEED[rows])
    run(physics, rows, range(7))
    twin = clone(physics)
    assert (twin.parameters, twin.timestep) == (physics.parameters, 0.002)
    np.testing.assert_array_equal(answers(twin), answers(physics))
    np.testing.assert_array_equal(run(twin, rows), run(physics, rows))


def test_restore_undoes_the_first_change_of_the_parameters_too() -> None:
    rows = np.arange(4)
    physics = LinkPhysics(num_simulations=4)
    physics.reset(rows, START[rows], SPEED[rows])
    state, at_snapshot = physics.snapshot(), answers(physics)
    expected = run(physics, rows)
    physics.set_parameters(rows, INERTIA[rows], FRICTION[rows], MOMENT[rows])
    physics.reset(rows, START[rows + 4], SPEED[rows + 4])
    assert (run(physics, rows) != expected).any()
    physics.restore(state)
    np.testing.assert_array_equal(answers(physics), at_snapshot)
    np.testing.assert_array_equal(run(physics, rows), expected)


def test_restore_wants_a_snapshot_of_as_many_links() -> None:
    for other in (LinkPhysics(num_simulations=3), Physics(num_simulations=2)):
        with pytest.raises(InvalidValueError, match="snapshot"):
            LinkPhysics(num_simulations=2).restore(other.snapshot())


@pytest.mark.parametrize(
    ("name", "bad", "unit"),
    [
        ("inertia", 0.0, "kg·m²"),
        ("inertia", -1.0, "kg·m²"),
        ("inertia", math.nan, "kg·m²"),
        ("inertia", math.inf, "kg·m²"),
        ("viscous_friction", -1e-9, "N·m·s/rad"),
        ("viscous_friction", math.inf, "N·m·s/rad"),
        ("gravity_moment", -1e-9, "N·m"),
        ("gravity_moment", math.nan, "N·m"),
    ],
)
def test_set_parameters_refuses_impossible_ones_and_changes_nothing(name: str, bad: float, unit: str) -> None:
    rows = np.arange(4)
    physics, undisturbed = simulations(rows), simulations(rows)
    numbers = {"inertia": INERTIA[4:6], "viscous_friction": FRICTION[4:6], "gravity_moment": MOMENT[4:6]}
    numbers[name] = np.array([numbers[name][0], bad])
    with pytest.raises(InvalidValueError, match=name) as caught:
        physics.set_parameters(np.array([0, 2]), **numbers)
    assert caught.value.unit == unit
    np.testing.assert_equal(caught.value.value, bad)
    np.testing.assert_array_equal(run(physics, rows), run(undisturbed, rows))


@pytest.mark.parametrize("name", ["inertia", "viscous_friction", "gravity_moment"])
@pytest.mark.parametrize("shape", [(), (1,), (3,), (2, 1)])
def test_set_parameters_wants_a_number_for_each_simulation(name: str, shape: tuple[int, ...]) -> None:
    numbers = {key: np.ones(2) for key in ("inertia", "viscous_friction", "gravity_moment")}
    numbers[name] = np.ones(shape)
    with pytest.raises(ShapeError, match=name):
        LinkPhysics(num_simulations=3).set_parameters(np.array([0, 2]), **numbers)


def test_reset_refuses_the_arms_vectors_and_what_is_not_finite() -> None:
    physics = LinkPhysics()
    with pytest.raises(ShapeError, match="joint_position"):
        physics.reset(ONE, np.zeros((1, 3)), np.zeros((1, 1)))
    with pytest.raises(NonFiniteError, match="joint_velocity"):
        physics.reset(ONE, np.zeros((1, 1)), np.full((1, 1), np.nan))


def test_a_motion_beyond_all_bounds_is_reported_until_the_next_reset() -> None:
    physics = LinkPhysics(num_simulations=2)
    physics.reset(np.arange(2), np.array([[0.1], [1e11]]), np.zeros((2, 1)))
    physics.advance(1)
    assert not physics.within_limits
    assert physics.unstable.tolist() == [False, True]
    physics.reset(np.array([1]), np.zeros((1, 1)), np.zeros((1, 1)))
    assert physics.within_limits


def test_a_snapshot_holds_that_a_simulation_was_unstable() -> None:
    physics, other = LinkPhysics(num_simulations=2), LinkPhysics(num_simulations=2)
    stable = physics.snapshot()
    physics.reset(np.arange(2), np.array([[0.1], [1e11]]), np.zeros((2, 1)))
    physics.advance(1)
    other.restore(physics.snapshot())
    assert other.unstable.tolist() == [False, True]
    other.restore(stable)
    assert other.unstable.tolist() == [False, False]


@pytest.mark.parametrize("timestep", [0.0, -0.001, math.nan, math.inf])
def test_timestep_must_be_positive(timestep: float) -> None:
    with pytest.raises(InvalidValueError, match="timestep") as caught:
        LinkPhysics(timestep=timestep)
    assert caught.value.unit == "s"


@pytest.mark.parametrize("count", [0, -1])
def test_there_must_be_a_simulation(count: int) -> None:
    with pytest.raises(InvalidValueError, match="num_simulations"):
        LinkPhysics(num_simulations=count)
