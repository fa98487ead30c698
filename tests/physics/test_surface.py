"""The elastic surface as a value, and simulations against an ideal wall integrated in numpy."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from prp_gym.errors import InvalidValueError, ShapeError
from prp_gym.physics import MEASUREMENT_SIZE, Physics, PhysicsSettings, Surface
from prp_gym.physics.surface import IMPEDANCE, solver_reference
from tests.physics.test_surface_contract import (
    ARM,
    COUNT,
    DAMPING,
    OFFSET,
    STIFFNESS,
    compliance,
    planes,
    world,
)
from tests.support.pinocchio_model import Array

PROPERTY = settings(max_examples=200, deadline=None, derandomize=True)
ROUNDING = 4e-15  # unit vectors and quaternions after a dozen operations
COMPONENT = st.floats(-10.0, 10.0).map(lambda value: value if abs(value) > 1e-6 else 0.0)
VECTORS = st.tuples(COMPONENT, COMPONENT, COMPONENT).filter(any)
NEARLY_DOWN = [(1e-5, 0, -1), (0, 1e-6, -1), (-1e-6, 1e-6, -1), (1e-8, -1e-8, -1)]
AXES = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]
NAN, INF = math.nan, math.inf


def turned_z_axis(quaternion: Array) -> Array:
    """The third column of the rotation matrix of (w, x, y, z)."""
    w, x, y, z = quaternion
    return np.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])


def test_single_plane_is_a_surface_of_one_row() -> None:
    surface = Surface.single(50.0, (0.0, -2.0, 0.0), 0.44, damping=3.0)
    assert surface.stiffness.tolist() == [50.0]
    assert surface.damping.tolist() == [3.0]
    assert surface.normal.tolist() == [[0.0, -1.0, 0.0]]
    assert surface.offset.tolist() == [0.44]


def test_single_plane_is_undamped_by_default() -> None:
    assert Surface.single(50.0, (1.0, 0.0, 0.0), 0.0).damping.tolist() == [0.0]


def test_lists_and_integers_become_arrays_of_doubles() -> None:
    surface = Surface([1, 2], [0, 1], [[0, 0, 3], [4, 0, 0]], [-1, 1])  # type: ignore[arg-type]
    for values in (surface.stiffness, surface.damping, surface.normal, surface.offset):
        assert values.dtype == np.float64
    assert surface.normal.tolist() == [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]


@PROPERTY
@given(normal=VECTORS)
def test_normals_are_scaled_to_unit_length_and_keep_their_direction(
    normal: tuple[float, float, float],
) -> None:
    unit = Surface.single(1.0, normal, 0.0).normal[0]
    assert float(unit @ unit) == pytest.approx(1.0, rel=0, abs=ROUNDING)
    assert float(unit @ normal) == pytest.approx(math.dist(normal, (0, 0, 0)), rel=ROUNDING)


def test_offset_is_not_scaled_with_the_normal() -> None:
    assert Surface.single(1.0, (0.0, 5.0, 0.0), 0.3).offset.tolist() == [0.3]


@PROPERTY
@given(normal=st.one_of(VECTORS, st.sampled_from(NEARLY_DOWN)))
def test_quaternions_are_rotations_of_the_z_axis_into_the_normals(
    normal: tuple[float, float, float],
) -> None:
    surface = Surface.single(1.0, normal, 0.0)
    quaternion = surface.quaternions()[0]
    assert float(quaternion @ quaternion) == pytest.approx(1.0, rel=0, abs=ROUNDING)
    # a normal within 1.4e-6 rad of straight down counts as straight down
    np.testing.assert_allclose(turned_z_axis(quaternion), surface.normal[0], rtol=0, atol=1.5e-6)


@pytest.mark.parametrize("normal", AXES)
def test_quaternions_of_the_axes_are_exact(normal: tuple[float, float, float]) -> None:
    quaternion = Surface.single(1.0, normal, 0.0).quaternions()[0]
    np.testing.assert_allclose(turned_z_axis(quaternion), normal, rtol=0, atol=ROUNDING)


def test_quaternions_of_many_planes_are_those_of_each() -> None:
    normals = np.random.default_rng(1).normal(size=(20, 3))
    normals[3] = (0.0, 0.0, -1.0)
    ones = np.ones(20)
    together = Surface(ones, ones, normals, ones).quaternions()
    alone = [Surface.single(1.0, (n[0], n[1], n[2]), 1.0).quaternions()[0] for n in normals]
    np.testing.assert_array_equal(together, alone)


def test_solver_reference_gives_spring_and_damper_after_the_solvers_own_scaling() -> None:
    generator = np.random.default_rng(2)
    stiffness, damping = generator.uniform(1.0, 5000.0, 30), generator.uniform(0.0, 50.0, 30)
    inverse_weight = generator.uniform(0.5, 2.0, 30)
    reference = solver_reference(stiffness, damping, inverse_weight)
    # [M]: direct coefficients k, b act as k/d² and b/d; the row's regulariser is (1-d)/d Â, and the
    # position term carries another d
    regulariser = (1 - IMPEDANCE) / IMPEDANCE * inverse_weight
    per_depth = IMPEDANCE * (-reference[:, 0] / IMPEDANCE**2) / regulariser
    per_rate = (-reference[:, 1] / IMPEDANCE) / regulariser
    # a handful of multiplications
    np.testing.assert_allclose(per_depth, stiffness, rtol=1e-14, atol=0)
    np.testing.assert_allclose(per_rate, damping, rtol=1e-14, atol=0)


@pytest.mark.parametrize("stiffness", [0.0, -1.0, NAN, INF])
def test_stiffness_must_be_positive_and_finite(stiffness: float) -> None:
    with pytest.raises(InvalidValueError, match="surface stiffness") as caught:
        Surface.single(stiffness, (0.0, -1.0, 0.0), 0.44)
    assert caught.value.unit == "N/m"


@pytest.mark.parametrize("damping", [-1e-9, NAN, INF])
def test_damping_must_not_be_negative_and_be_finite(damping: float) -> None:
    with pytest.raises(InvalidValueError, match="surface damping") as caught:
        Surface.single(50.0, (0.0, -1.0, 0.0), 0.44, damping=damping)
    assert caught.value.unit == "N·s/m"


@pytest.mark.parametrize("normal", [(0, 0, 0), (0, NAN, 1), (INF, 0, 0)])
def test_normal_must_have_a_direction(normal: tuple[float, float, float]) -> None:
    with pytest.raises(InvalidValueError, match="surface normal"):
        Surface.single(50.0, normal, 0.44)


@pytest.mark.parametrize("offset", [NAN, INF, -INF])
def test_offset_must_be_finite(offset: float) -> None:
    with pytest.raises(InvalidValueError, match="surface offset"):
        Surface.single(50.0, (0.0, -1.0, 0.0), offset)


def test_one_bad_plane_among_good_ones_is_named_by_its_value() -> None:
    with pytest.raises(InvalidValueError) as caught:
        Surface(np.array([1.0, -7.0]), np.zeros(2), np.eye(3)[:2], np.zeros(2))
    assert caught.value.value == -7.0


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("stiffness", np.ones((2, 1))),
        ("damping", np.zeros(3)),
        ("damping", np.float64(0.0)),
        ("normal", np.ones(3)),
        ("normal", np.ones((2, 2))),
        ("normal", np.ones((3, 3))),
        ("offset", np.zeros((2, 1))),
        ("offset", np.zeros(1)),
    ],
)
def test_every_array_has_one_row_for_each_simulation(name: str, values: Array) -> None:
    arrays = {
        "stiffness": np.ones(2),
        "damping": np.zeros(2),
        "normal": np.ones((2, 3)),
        "offset": np.zeros(2),
    }
    assert Surface(**arrays).stiffness.shape == (2,)
    with pytest.raises(ShapeError, match="surface"):
        Surface(**{**arrays, name: values})


def test_stiffness_without_a_row_for_each_simulation_is_refused() -> None:
    with pytest.raises(ShapeError, match="surface stiffness"):
        Surface(np.float64(1.0), np.float64(0.0), np.ones(3), np.float64(0.0))  # type: ignore[arg-type]


@pytest.mark.parametrize("stops", [True, False])
def test_contact_force_is_measured_where_there_is_a_surface(stops: bool) -> None:
    without = Physics(settings=PhysicsSettings(joint_stops=stops))
    assert without.measurement_size == MEASUREMENT_SIZE == 18
    physics = Physics(settings=PhysicsSettings(joint_stops=stops, surface=True))
    assert physics.measurement_size == 21
    # the slide far behind the plane, and where there are stops behind its own too
    physics.set_surface(np.arange(1), Surface.single(100.0, (0.0, -1.0, 0.0), 0.3))
    physics.reset(np.arange(1), np.array([[0.0, -0.31, 0.0]]), np.zeros((1, 3)))
    tip = ARM.forward_kinematics((0.0, -0.31, 0.0))[1]
    # the solver's spurious mass of 0.13 g feels the stop's push of some 100 m/s²
    np.testing.assert_allclose(physics.measurement[0, 18:], [0.0, 100.0 * (0.3 + tip), 0.0], atol=0.05)
    np.testing.assert_array_equal(physics.contact_force, physics.measurement[:, 18:])
    # a difference of lengths below one
    np.testing.assert_allclose(physics.stop_violation, [[0.0, -0.01 * stops, 0.0]], rtol=0, atol=1e-15)
    assert physics.joints_at_stop.tolist() == [[False, stops, False]]


def ideal_acceleration(q: Array, velocity: Array, torque: Array) -> Array:
    """The arm against max(0, K depth + D rate), the plane's normal along -y."""
    rate = (ARM.analytical_jacobian(q)[:, 1] * velocity).sum(axis=-1)
    depth = ARM.forward_kinematics(q)[:, 1] + OFFSET
    force = np.zeros((COUNT, 3))
    force[:, 1] = np.where(depth > 0.0, np.maximum(0.0, STIFFNESS * depth + DAMPING * rate), 0.0)
    return ARM.forward_dynamics(q, velocity, torque, force)


def semi_implicit_euler(q: Array, velocity: Array, torque: Array, step: float) -> tuple[Array, Array]:
    velocity = velocity + step * ideal_acceleration(q, velocity, torque)
    return q + step * velocity, velocity


def runge_kutta(q: Array, velocity: Array, torque: Array, step: float) -> tuple[Array, Array]:
    """Two classical steps of fourth order."""
    h = step / 2
    for _ in range(2):
        a_1 = ideal_acceleration(q, velocity, torque)
        v_2 = velocity + h / 2 * a_1
        a_2 = ideal_acceleration(q + h / 2 * velocity, v_2, torque)
        v_3 = velocity + h / 2 * a_2
        a_3 = ideal_acceleration(q + h / 2 * v_2, v_3, torque)
        v_4 = velocity + h * a_3
        a_4 = ideal_acceleration(q + h * v_3, v_4, torque)
        q = q + h / 6 * (velocity + 2 * v_2 + 2 * v_3 + v_4)
        velocity = velocity + h / 6 * (a_1 + 2 * a_2 + 2 * a_3 + a_4)
    return q, velocity


def largest_deviation(
    integrate: Callable[[Array, Array, Array, float], tuple[Array, Array]], timestep: float, milliseconds: int
) -> Array:
    """Of the tip in a compliance run with a torque every 1 ms, for each surface (8) [m]."""
    settings = PhysicsSettings(surface=True, joint_stops=False, timestep=timestep)
    physics = world(planes(STIFFNESS, DAMPING), settings, np.zeros(3))
    q, velocity, largest = np.zeros((COUNT, 3)), np.zeros((COUNT, 3)), np.zeros(COUNT)
    for _ in range(milliseconds):
        physics.set_torque(compliance(physics.joint_position, physics.joint_velocity))
        physics.advance(round(1e-3 / timestep))
        q, velocity = integrate(q, velocity, compliance(q, velocity), 1e-3)
        apart = np.abs(ARM.forward_kinematics(q)[:, :3] - physics.tip_position).max(axis=-1)
        largest = np.maximum(largest, apart)
    return largest


def test_compliance_run_follows_the_ideal_wall_of_the_same_integrator() -> None:
    # 3.6e-6 measured: the spurious mass of 0.13 g acts while the tip hits and leaves at 0.5 m/s
    assert (largest_deviation(semi_implicit_euler, 1e-3, 3000) < 8e-6).all()


def test_compliance_run_converges_to_the_exact_ideal_wall() -> None:
    coarse, fine = (largest_deviation(runge_kutta, timestep, 1000) for timestep in (1e-3, 1e-4))
    # first order: half a step's travel at 0.5 m/s; impact on the stiffest plane adds half of that
    assert (coarse < 5e-4).all()
    # a tenth of it, and on the stiffest damped plane the force's jump of 100 N within a step
    assert (fine < 7e-5).all()
    assert (fine < coarse / 5).all()
