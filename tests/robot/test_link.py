"""The one-joint link: its equation of motion against hand-made numbers, slopes and energy balances."""

import copy
import math
import pickle
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from prp_gym.errors import InvalidValueError, ShapeError
from prp_gym.robot import NOMINAL_LINK, Link, LinkParameters, PRPArm
from tests.support.pinocchio_model import Array

PROPERTY = settings(max_examples=50, deadline=None, derandomize=True)
LINK = Link()
OTHER = Link(LinkParameters(inertia=0.07, viscous_friction=0.4, gravity_moment=3.0))
BOTH = pytest.mark.parametrize("link", [LINK, OTHER], ids=["report", "other"])
ROUNDING = 1e-13  # a handful of operations on numbers of up to 100
STEP = 1e-5  # of central differences: truncation and rounding both about 1e-11 ...
DIFFERENCE = 1e-9  # ... and hence this tolerance
ANGLE, SPEED = st.floats(-7.0, 7.0), st.floats(-10.0, 10.0)
NAN, INFINITY = math.nan, math.inf


def random_state(seed: int, rows: int = 50) -> tuple[Array, Array, Array, Array]:
    """Positions, two velocities and accelerations (rows, 1)."""
    values = np.random.default_rng(seed).uniform(-5.0, 5.0, size=(4, rows, 1))
    return values[0], values[1], values[2], values[3]


def test_default_link_is_the_reports() -> None:
    assert LINK.parameters == NOMINAL_LINK == LinkParameters(0.5, 0.15, 1.85, (30.0,))
    np.testing.assert_array_equal(LINK.parameter_vector(), [0.5, 0.15, 1.85])


def test_joint_counts_are_those_of_the_models_vectors() -> None:
    assert Link.joint_count == LINK.gravity_vector([0.3]).size == 1
    assert PRPArm.joint_count == PRPArm().gravity_vector(np.zeros(3)).size == 3


@pytest.mark.parametrize(
    ("q", "velocity", "torque", "acceleration"),
    [
        (0.0, 0.0, 0.0, 0.0),  # hangs
        (math.pi / 2, 0.0, 0.0, -3.7),  # falls from the horizontal: -1.85/0.5
        (math.pi / 2, 0.0, 1.85, 0.0),  # held there
        (-math.pi / 6, 0.0, 0.0, 1.85),  # falls back from the other side
        (0.0, 2.0, 0.0, -0.6),  # friction alone: -0.15 * 2/0.5
        (0.0, 0.0, 3.0, 6.0),  # torque alone
    ],
)
def test_acceleration_is_the_one_worked_out_by_hand(
    q: float, velocity: float, torque: float, acceleration: float
) -> None:
    # an exact zero is a difference of terms of order one
    assert LINK.forward_dynamics([q], [velocity], [torque])[0] == pytest.approx(acceleration, abs=ROUNDING)


@BOTH
def test_gravity_is_the_slope_of_the_potential(link: Link) -> None:
    q = random_state(0)[0]
    slope = (link.potential_energy(q + STEP) - link.potential_energy(q - STEP)) / (2 * STEP)
    np.testing.assert_allclose(link.gravity_vector(q)[:, 0], slope, rtol=0, atol=DIFFERENCE)
    assert link.potential_energy([0.0]) == 0.0
    # lifted by twice the lever arm of the weight
    assert link.potential_energy([math.pi]) == pytest.approx(2 * link.parameters.gravity_moment, rel=ROUNDING)


@BOTH
def test_inertia_is_the_curvature_of_the_kinetic_energy(link: Link) -> None:
    q, velocity, _, _ = random_state(1)
    # quadratic: a central difference is exact, so that a wide one has only rounding
    momentum = (link.kinetic_energy(q, velocity + 1.0) - link.kinetic_energy(q, velocity - 1.0)) / 2
    expected = (link.inertia_matrix(q) @ velocity[..., None])[:, 0, 0]
    np.testing.assert_allclose(momentum, expected, rtol=0, atol=ROUNDING)
    assert link.kinetic_energy([0.3], [0.0]) == 0.0


@BOTH
def test_energy_changes_by_the_power_of_torque_less_friction(link: Link) -> None:
    q, velocity, torque, _ = random_state(2)
    acceleration = link.forward_dynamics(q, velocity, torque)

    def energy(time: float) -> Array:
        ahead, speed = q + time * velocity, velocity + time * acceleration
        return link.kinetic_energy(ahead, speed) + link.potential_energy(ahead)

    rate = (energy(STEP) - energy(-STEP)) / (2 * STEP)
    power = ((torque - link.friction_force(velocity)) * velocity)[:, 0]
    # speeds of 5 and accelerations of 100 enter the truncation error, energies of 10 J the rounding
    np.testing.assert_allclose(rate, power, rtol=0, atol=20 * DIFFERENCE)


@PROPERTY
@given(q=ANGLE, velocity=SPEED)
def test_friction_never_adds_energy(q: float, velocity: float) -> None:
    assert LINK.friction_force([velocity])[0] * velocity == pytest.approx(0.15 * velocity**2, rel=ROUNDING)
    bias, gravity = LINK.bias_force([q], [velocity]), LINK.gravity_vector([q])
    np.testing.assert_allclose(bias - gravity, LINK.friction_force([velocity]), rtol=0, atol=ROUNDING)


@BOTH
def test_forward_dynamics_solves_the_equation_written_with_matrices(link: Link) -> None:
    q, velocity, torque, _ = random_state(3)
    acceleration = link.forward_dynamics(q, velocity, torque)
    C = link.coriolis_matrix(q, velocity)
    np.testing.assert_array_equal(C, np.zeros((50, 1, 1)))
    inertial = (link.inertia_matrix(q) @ acceleration[..., None])[..., 0]
    moments = inertial + link.friction_force(velocity) + link.gravity_vector(q)
    np.testing.assert_allclose(moments, torque, rtol=0, atol=ROUNDING)


@BOTH
def test_regressor_times_parameters_is_the_torque_of_the_reference_motion(link: Link) -> None:
    q, velocity, reference, acceleration = random_state(4)
    Y = link.regressor(q, velocity, reference, acceleration)
    assert Y.shape == (50, 1, 3)
    inertial = (link.inertia_matrix(q) @ acceleration[..., None])[..., 0]
    expected = inertial + link.friction_force(reference) + link.gravity_vector(q)
    np.testing.assert_allclose(Y @ link.parameter_vector(), expected, rtol=0, atol=ROUNDING)


def test_regressors_columns_are_acceleration_velocity_and_sine() -> None:
    np.testing.assert_array_equal(LINK.regressor([0.7], [9.0], [-2.0], [5.0]), [[5.0, -2.0, math.sin(0.7)]])


def answers(link: Link, q: Array, velocity: Array, torque: Array) -> list[Array]:
    return [
        link.inertia_matrix(q),
        link.coriolis_matrix(q, velocity),
        link.gravity_vector(q),
        link.friction_force(velocity),
        link.bias_force(q, velocity),
        link.forward_dynamics(q, velocity, torque),
        link.kinetic_energy(q, velocity),
        link.potential_energy(q),
        link.regressor(q, velocity, velocity, torque),
    ]


def test_methods_broadcast_and_leave_their_arguments_alone() -> None:
    q, velocity, torque, _ = (values.reshape(5, 10, 1) for values in random_state(5))
    before = [values.copy() for values in (q, velocity, torque)]
    together = answers(LINK, q, velocity, torque)
    for row, column in ((0, 0), (3, 7)):
        alone = answers(LINK, q[row, column], velocity[row, column], torque[row, column])
        for one, many in zip(alone, together, strict=True):
            np.testing.assert_array_equal(one, many[row, column])
    for values, kept in zip((q, velocity, torque), before, strict=True):
        np.testing.assert_array_equal(values, kept)
    one = np.array([0.4])
    assert LINK.coriolis_matrix(one, velocity).shape == (5, 10, 1, 1)
    assert LINK.kinetic_energy(q, one).shape == (5, 10)
    assert LINK.regressor(one, one, velocity, one).shape == (5, 10, 1, 3)


@pytest.mark.parametrize("wrong", [0.0, [0.0, 0.0, 0.0], np.zeros((1, 2))])
def test_vectors_of_another_size_are_refused(wrong: Any) -> None:
    good = [0.0]
    calls: list[tuple[Callable[..., Array], list[Any]]] = [
        (LINK.inertia_matrix, [wrong]),
        (LINK.coriolis_matrix, [good, wrong]),
        (LINK.gravity_vector, [wrong]),
        (LINK.friction_force, [wrong]),
        (LINK.bias_force, [good, wrong]),
        (LINK.forward_dynamics, [good, good, wrong]),
        (LINK.kinetic_energy, [good, wrong]),
        (LINK.potential_energy, [wrong]),
        (LINK.regressor, [good, good, good, wrong]),
    ]
    for call, arguments in calls:
        with pytest.raises(ShapeError):
            call(*arguments)


@pytest.mark.parametrize(
    ("name", "bad", "unit"),
    [
        ("inertia", 0.0, "kg·m²"),
        ("inertia", -0.5, "kg·m²"),
        ("inertia", NAN, "kg·m²"),
        ("inertia", INFINITY, "kg·m²"),
        ("viscous_friction", -1e-9, "N·m·s/rad"),
        ("viscous_friction", INFINITY, "N·m·s/rad"),
        ("gravity_moment", -1e-9, "N·m"),
        ("gravity_moment", NAN, "N·m"),
        ("torque_limit", (0.0,), "N·m"),
        ("torque_limit", (INFINITY,), "N·m"),
        ("torque_limit", (), "N·m"),
        ("torque_limit", (1.0, 2.0), "N·m"),
    ],
)
def test_impossible_parameters_are_refused(name: str, bad: Any, unit: str) -> None:
    with pytest.raises(InvalidValueError, match=name) as caught:
        replace(NOMINAL_LINK, **{name: bad})
    assert caught.value.unit == unit


def test_frictionless_and_weightless_links_are_links() -> None:
    free = Link(LinkParameters(inertia=2.0, viscous_friction=0.0, gravity_moment=0.0))
    np.testing.assert_array_equal(free.forward_dynamics([1.0], [3.0], [4.0]), [2.0])


def test_parameters_become_plain_floats() -> None:
    parameters = LinkParameters(np.float64(1), 0, 2, (np.float64(3),))
    values = (
        parameters.inertia,
        parameters.viscous_friction,
        parameters.gravity_moment,
        *parameters.torque_limit,
    )
    assert [type(value) for value in values] == [float] * 4
    assert parameters == LinkParameters(1.0, 0.0, 2.0, (3.0,))


def test_links_of_equal_parameters_are_equal() -> None:
    twin = Link(LinkParameters(0.07, 0.4, 3.0))
    assert twin == OTHER
    assert hash(twin) == hash(OTHER)
    assert twin != LINK
    assert PRPArm() != LINK
    assert copy.deepcopy(OTHER) == pickle.loads(pickle.dumps(OTHER)) == OTHER
    assert repr(OTHER.parameters) in repr(OTHER)
