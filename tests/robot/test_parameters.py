"""The arm's numbers: the design's table, the report's inertia errata, and values that are refused."""

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from prp_gym.errors import InvalidValueError
from prp_gym.robot import NOMINAL, REPORT, ArmGeometry, RobotParameters
from tests.support.pinocchio_model import TABLE, random_arm

PROPERTY = settings(max_examples=50, deadline=None, derandomize=True)
ROUNDING = 1e-14  # relative: a dozen operations in double precision
FACTORS = st.tuples(*[st.floats(0.01, 100.0)] * 3)
LENGTHS = st.lists(st.floats(1e-3, 10.0), min_size=12, max_size=12)
NAN, INFINITY = math.nan, math.inf


def test_lengths_are_those_of_the_table() -> None:
    geometry = NOMINAL.geometry
    assert (geometry.base_height, geometry.first_link_offset) == (0.15, 0.40)
    assert (geometry.slide_offset, geometry.third_link_length) == (0.30, 0.24)
    assert (geometry.first_link_radius, geometry.first_link_cylinder_length) == (0.02, 0.35)
    assert (geometry.second_link_length, geometry.second_link_width) == (0.30, 0.03)
    assert geometry.second_link_height == 0.03
    assert (geometry.third_link_radius, geometry.third_link_cylinder_length) == (0.02, 0.24)


def test_limits_and_gravity_are_those_of_the_table() -> None:
    assert NOMINAL.joint_lower == (-math.pi, -0.3, -math.pi)
    assert NOMINAL.joint_upper == (math.pi, 0.0, math.pi)
    assert NOMINAL.torque_limit == (50.0, 100.0, 10.0)
    assert NOMINAL.gravity == 9.81
    assert NOMINAL.viscous_friction == NOMINAL.coulomb_friction == (0.0, 0.0, 0.0)


def test_masses_follow_from_density_and_volume() -> None:
    # printed with five decimals
    np.testing.assert_allclose(NOMINAL.link_mass, (1.19192, 0.73170, 0.81732), rtol=0, atol=5e-6)
    np.testing.assert_allclose(NOMINAL.link_mass, TABLE.masses, rtol=ROUNDING)


def test_centers_of_mass_are_those_of_the_table() -> None:
    geometry = NOMINAL.geometry
    # the middle of a cylinder that spans 0.025 to 0.375 m
    assert geometry.first_link_center_of_mass == pytest.approx((0.025 + 0.375) / 2, rel=ROUNDING)
    assert geometry.second_link_center_of_mass == pytest.approx(0.15, rel=ROUNDING)
    assert geometry.third_link_center_of_mass == pytest.approx(0.12, rel=ROUNDING)


def test_inertias_are_those_of_solid_cylinders_and_a_box() -> None:
    np.testing.assert_allclose(NOMINAL.link_inertia, TABLE.moments, rtol=ROUNDING)


def test_erratum_cylinder_across_its_axis_takes_a_twelfth() -> None:
    (axial, across, other), _, _ = NOMINAL.link_inertia
    mass, radius, length = NOMINAL.link_mass[0], 0.02, 0.35
    assert across == other == pytest.approx(mass * (3 * radius**2 + length**2) / 12, rel=ROUNDING)
    assert axial == pytest.approx(mass * radius**2 / 2, rel=ROUNDING)
    assert mass * (3 * radius**2 + length**2) / 2 > 5 * across  # what the report prints


def test_erratum_box_long_across_the_vertical_is_heavy_about_it() -> None:
    about_across, about_slide, about_vertical = NOMINAL.link_inertia[1]
    mass, a, b, c = NOMINAL.link_mass[1], 0.30, 0.03, 0.03
    assert about_vertical == pytest.approx(mass * (a**2 + b**2) / 12, rel=ROUNDING)
    assert about_across == pytest.approx(mass * (a**2 + c**2) / 12, rel=ROUNDING)
    assert about_slide == pytest.approx(mass * (b**2 + c**2) / 12, rel=ROUNDING)


def test_report_preset_differs_only_in_its_inertias() -> None:
    assert dataclasses.replace(REPORT, link_inertia=NOMINAL.link_inertia) == NOMINAL
    assert REPORT.link_inertia != NOMINAL.link_inertia


def test_report_preset_counts_the_parallel_axis_term_of_a_cylinder() -> None:
    for link, radius, length in ((0, 0.02, 0.35), (2, 0.02, 0.24)):
        mass = NOMINAL.link_mass[link]
        printed = mass * (3 * radius**2 + length**2) / 2 + mass * length**2 / 4
        assert max(REPORT.link_inertia[link]) == pytest.approx(printed, rel=ROUNDING)


def test_from_geometry_of_the_nominal_lengths_is_the_nominal_arm() -> None:
    assert RobotParameters.from_geometry(ArmGeometry()) == NOMINAL


@PROPERTY
@given(lengths=LENGTHS, density=st.floats(0.1, 1e4))
def test_solids_of_any_lengths_have_masses_and_inertias_that_are_accepted(
    lengths: list[float], density: float
) -> None:
    geometry = ArmGeometry(*lengths)
    parameters = RobotParameters.from_geometry(geometry, density=density)
    np.testing.assert_allclose(parameters.link_mass, density * np.array(geometry.volumes()), rtol=ROUNDING)
    assert parameters.link_inertia == geometry.inertias(parameters.link_mass)


def test_scaling_multiplies_every_mass_and_moment_of_its_link() -> None:
    parameters, _ = random_arm(0)  # nine different moments
    scaled = parameters.scaled((2.0, 3.0, 0.5))
    np.testing.assert_array_equal(scaled.link_mass, np.multiply(parameters.link_mass, (2.0, 3.0, 0.5)))
    expected = np.multiply(parameters.link_inertia, [[2.0], [3.0], [0.5]])
    np.testing.assert_array_equal(scaled.link_inertia, expected)


@PROPERTY
@given(first=FACTORS, second=FACTORS)
def test_scaling_twice_is_scaling_by_the_product(
    first: tuple[float, float, float], second: tuple[float, float, float]
) -> None:
    twice = NOMINAL.scaled(first).scaled(second)
    once = NOMINAL.scaled([a * b for a, b in zip(first, second, strict=True)])
    np.testing.assert_allclose(twice.link_mass, once.link_mass, rtol=ROUNDING)
    np.testing.assert_allclose(twice.link_inertia, once.link_inertia, rtol=ROUNDING)


def test_other_masses_scale_the_inertias_and_keep_the_shapes() -> None:
    masses = (0.9, 0.5, 0.7)
    changed = NOMINAL.with_masses(masses)
    np.testing.assert_allclose(changed.link_mass, masses, rtol=ROUNDING)
    np.testing.assert_allclose(changed.link_inertia, NOMINAL.geometry.inertias(masses), rtol=ROUNDING)
    assert changed.geometry == NOMINAL.geometry


def test_parameters_are_values_that_cannot_be_changed() -> None:
    assert RobotParameters() == NOMINAL
    assert hash(RobotParameters()) == hash(NOMINAL)
    for value, name in ((NOMINAL, "gravity"), (NOMINAL.geometry, "base_height")):
        with pytest.raises(dataclasses.FrozenInstanceError):
            setattr(value, name, 1.0)


@pytest.mark.parametrize("length", [0.0, -0.1, NAN, INFINITY])
@pytest.mark.parametrize("name", [item.name for item in dataclasses.fields(ArmGeometry)])
def test_length_that_is_not_positive_and_finite_is_refused(name: str, length: float) -> None:
    lengths: dict[str, Any] = {name: length}
    with pytest.raises(InvalidValueError, match=f"{name} is .* m; allowed: 1e-06 to 1000") as caught:
        ArmGeometry(**lengths)
    assert caught.value.what == name
    assert caught.value.unit == "m"


@pytest.mark.parametrize("bad", [-1.0, NAN, INFINITY])
@pytest.mark.parametrize("joint", [0, 1, 2])
@pytest.mark.parametrize("name", ["link_mass", "torque_limit", "viscous_friction", "coulomb_friction"])
def test_negative_or_non_finite_number_is_refused(name: str, joint: int, bad: float) -> None:
    values = [1.0, 1.0, 1.0]
    values[joint] = bad
    arguments: dict[str, Any] = {name: tuple(values)}
    with pytest.raises(InvalidValueError, match=name) as caught:
        RobotParameters(**arguments)
    assert caught.value.value == pytest.approx(tuple(values), nan_ok=True)
    assert "0" in caught.value.allowed


@pytest.mark.parametrize("name", ["link_mass", "torque_limit"])
def test_zero_mass_or_torque_limit_is_refused(name: str) -> None:
    arguments: dict[str, Any] = {name: (1.0, 0.0, 1.0)}
    with pytest.raises(InvalidValueError, match=r"1e-15 to|1e-09 to"):
        RobotParameters(**arguments)


@pytest.mark.parametrize("name", ["link_mass", "torque_limit", "viscous_friction", "coulomb_friction"])
def test_two_numbers_for_three_joints_are_refused(name: str) -> None:
    arguments: dict[str, Any] = {name: (1.0, 1.0)}
    with pytest.raises(InvalidValueError, match="three numbers"):
        RobotParameters(**arguments)


@pytest.mark.parametrize(
    "arguments",
    [
        {"joint_lower": (-1.0, -1.0), "joint_upper": (1.0, 1.0)},
        {"link_inertia": ((1.0, 1.0, 1.0), (1.0, 1.0, 1.0))},
    ],
)
def test_two_ranges_or_inertias_for_three_joints_are_refused(arguments: dict[str, Any]) -> None:
    with pytest.raises(InvalidValueError):
        RobotParameters(**arguments)


@pytest.mark.parametrize("link", [1, 2, 3])
def test_inertia_that_no_solid_can_have_is_refused(link: int) -> None:
    moments = [(1.0, 1.0, 1.0)] * 3
    moments[link - 1] = (1.0, 1.0, 2.0 + 1e-9)
    with pytest.raises(InvalidValueError, match=f"link {link} .* no moment above the sum") as caught:
        RobotParameters(link_inertia=(moments[0], moments[1], moments[2]))
    assert caught.value.unit == "kg·m²"


def test_inertia_of_a_flat_plate_is_accepted() -> None:
    plate = (1.0, 1.0, 2.0)  # the limit of the triangle inequality
    assert RobotParameters(link_inertia=(plate, plate, plate)).link_inertia == (plate, plate, plate)


@pytest.mark.parametrize("moment", [0.0, -1.0, NAN])
def test_inertia_that_is_not_positive_is_refused(moment: float) -> None:
    with pytest.raises(InvalidValueError, match="link_inertia of link 2"):
        RobotParameters(link_inertia=((1.0, 1.0, 1.0), (moment, 1.0, 1.0), (1.0, 1.0, 1.0)))


@pytest.mark.parametrize("upper", [-0.3, -0.4])
def test_empty_joint_range_is_refused(upper: float) -> None:
    with pytest.raises(InvalidValueError, match=r"joint_upper .* allowed: above joint_lower") as caught:
        RobotParameters(joint_upper=(math.pi, upper, math.pi))
    assert caught.value.what == "joint_upper"


@pytest.mark.parametrize("gravity", [NAN, INFINITY, -9.81])
def test_gravity_that_is_negative_or_not_finite_is_refused(gravity: float) -> None:
    with pytest.raises(InvalidValueError, match=r"gravity is .* m/s²; allowed: 0 to 1e\+06"):
        RobotParameters(gravity=gravity)


def test_negative_density_is_refused() -> None:
    with pytest.raises(InvalidValueError, match="density"):
        RobotParameters.from_geometry(ArmGeometry(), density=-1.0)


def test_numpy_scalars_become_plain_numbers() -> None:
    mass = (np.float64(1.0), np.float64(0.5), np.float64(0.7))
    parameters = RobotParameters(
        geometry=ArmGeometry(base_height=np.float64(0.2)), link_mass=mass, gravity=np.float64(9.8)
    )
    assert parameters == RobotParameters(
        geometry=ArmGeometry(base_height=0.2), link_mass=(1.0, 0.5, 0.7), gravity=9.8
    )
    assert "np." not in repr(parameters)
