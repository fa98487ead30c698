"""Observation fields: one declaration for the space, the slices and the named parts."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from prp_gym.errors import ShapeError, UnknownNameError
from prp_gym.physics import MEASUREMENT_SIZE, LinkPhysics, Physics, PhysicsSettings, Surface
from prp_gym.tasks import Field, ObservationLayout
from prp_gym.tasks.fields import (
    CONTACT_FORCE,
    DESIRED_FORCE,
    JOINT_REFERENCE_FIELDS,
    LINK_FIELDS,
    LINK_REFERENCE_FIELDS,
    MEASURED_FIELDS,
    POSE_REFERENCE_FIELDS,
)

HEIGHT = Field("height", ("m",), "world", (0.0,), (2.0,), "of the tip")
SPEED = Field.symmetric("speed", ("rad/s", "m/s"), "joint", (5.0, 3.0), "of two joints")
LAYOUT = ObservationLayout((HEIGHT, SPEED))
DECLARED = (*MEASURED_FIELDS, *JOINT_REFERENCE_FIELDS)


def test_symmetric_field_has_opposite_bounds() -> None:
    assert SPEED.low == (-5.0, -3.0)
    assert SPEED.high == (5.0, 3.0)
    assert SPEED.shape == (2,)


def test_fields_lie_one_after_the_other_in_their_order() -> None:
    layout = ObservationLayout(DECLARED)
    assert layout.names == tuple(field.name for field in DECLARED)
    end = 0
    for field in DECLARED:
        part = layout.index(field.name)
        assert part == slice(end, end + len(field.units))
        end = part.stop
    assert layout.size == end


def test_split_of_one_observation_names_its_parts() -> None:
    parts = LAYOUT.split([1.0, 2.0, 3.0])
    assert list(parts) == ["height", "speed"]
    np.testing.assert_array_equal(parts["height"], [1.0])
    np.testing.assert_array_equal(parts["speed"], [2.0, 3.0])


@given(leading=st.lists(st.integers(0, 4), max_size=3), seed=st.integers(0, 2**32 - 1))
def test_split_keeps_leading_dimensions_and_loses_nothing(leading: list[int], seed: int) -> None:
    batch = np.random.default_rng(seed).normal(size=(*leading, LAYOUT.size))
    parts = LAYOUT.split(batch)
    assert parts["height"].shape == (*leading, 1)
    assert parts["speed"].shape == (*leading, 2)
    np.testing.assert_array_equal(np.concatenate(list(parts.values()), axis=-1), batch)


def test_split_returns_views_of_a_float64_observation() -> None:
    batch = np.zeros((4, LAYOUT.size))
    LAYOUT.split(batch)["speed"][2, 1] = 7.0
    assert batch[2, 2] == 7.0


def test_split_of_single_precision_gives_doubles_of_the_same_value() -> None:
    single = np.array([0.1, 0.2, 0.3], dtype=np.float32)
    parts = LAYOUT.split(single)
    assert {part.dtype for part in parts.values()} == {np.dtype(np.float64)}
    np.testing.assert_array_equal(np.concatenate(list(parts.values())), single)


@pytest.mark.parametrize("shape", [(), (0,), (2,), (4,), (3, 2), (3, 1), (2, 3, 4)])
def test_split_refuses_another_last_axis(shape: tuple[int, ...]) -> None:
    with pytest.raises(ShapeError, match="observation has shape") as caught:
        LAYOUT.split(np.zeros(shape))
    assert caught.value.shape == shape
    assert caught.value.expected == "(..., 3)"


def test_unknown_field_is_named_with_the_nearest_and_all_valid_ones() -> None:
    with pytest.raises(UnknownNameError, match="unknown observation field 'hieght'") as caught:
        LAYOUT.index("hieght")
    assert caught.value.kind == "observation field"
    assert caught.value.valid == ("height", "speed")
    assert "Did you mean 'height'?" in str(caught.value)


def test_space_has_the_declared_bounds_in_double_precision() -> None:
    space = LAYOUT.space()
    assert space.shape == (3,)
    assert space.dtype == np.float64
    np.testing.assert_array_equal(space.low, [0.0, -5.0, -3.0])
    np.testing.assert_array_equal(space.high, [2.0, 5.0, 3.0])


def test_layouts_are_equal_when_their_fields_are() -> None:
    same, other = ObservationLayout([HEIGHT, SPEED]), ObservationLayout([SPEED, HEIGHT])
    assert same == LAYOUT
    assert hash(same) == hash(LAYOUT)
    assert other != LAYOUT
    assert LAYOUT != (HEIGHT, SPEED)


OBSERVED = (
    *DECLARED,
    CONTACT_FORCE,
    *POSE_REFERENCE_FIELDS,
    DESIRED_FORCE,
    *LINK_FIELDS,
    *LINK_REFERENCE_FIELDS,
)


@pytest.mark.parametrize("field", OBSERVED, ids=lambda field: f"{field.name}-{field.shape[0]}")
def test_declared_field_has_finite_bounds_and_a_unit_for_each_component(field: Field) -> None:
    assert len(field.units) == len(field.low) == len(field.high)
    assert np.isfinite([*field.low, *field.high]).all()
    assert (np.array(field.low) < np.array(field.high)).all()
    assert all(field.units)
    assert field.frame in {"joint", "world"}
    assert field.description


def test_declared_names_are_those_of_the_design_document() -> None:
    assert [field.name for field in MEASURED_FIELDS] == [
        "joint_position",
        "joint_velocity",
        "end_effector_pose",
        "end_effector_velocity",
    ]
    assert [field.name for field in JOINT_REFERENCE_FIELDS] == [
        "desired_joint_position",
        "desired_joint_velocity",
        "desired_joint_acceleration",
    ]
    assert [field.name for field in POSE_REFERENCE_FIELDS] == [
        "desired_pose",
        "desired_velocity",
        "desired_acceleration",
    ]
    assert [field.name for field in (CONTACT_FORCE, DESIRED_FORCE)] == ["contact_force", "desired_force"]


def test_measured_fields_are_the_measurement_of_the_physics_in_its_order() -> None:
    layout = ObservationLayout(MEASURED_FIELDS)
    assert layout.size == MEASUREMENT_SIZE
    physics = Physics()
    physics.reset(np.arange(1), np.array([[0.3, -0.1, 0.7]]), np.array([[1.0, 0.2, -2.0]]))
    parts = layout.split(physics.measurement[0])
    np.testing.assert_array_equal(parts["joint_position"], physics.joint_position[0])
    np.testing.assert_array_equal(parts["joint_velocity"], physics.joint_velocity[0])
    np.testing.assert_array_equal(parts["end_effector_pose"][:3], physics.tip_position[0])
    np.testing.assert_array_equal(parts["end_effector_velocity"][:3], physics.tip_velocity[0])


def test_contact_force_is_the_next_in_the_measurement_of_a_world_with_a_surface() -> None:
    layout = ObservationLayout((*MEASURED_FIELDS, CONTACT_FORCE))
    physics = Physics(settings=PhysicsSettings(surface=True))
    physics.set_surface(np.arange(1), Surface.single(100.0, (0.0, -1.0, 0.0), 0.5))
    physics.reset(np.arange(1), np.array([[0.0, -0.2, 0.0]]), np.zeros((1, 3)))
    assert layout.size == physics.measurement_size
    force = layout.split(physics.measurement[0])["contact_force"]
    np.testing.assert_array_equal(force, physics.contact_force[0])
    assert force[1] > 1.0


def test_fields_of_the_link_are_the_measurement_of_its_physics() -> None:
    layout = ObservationLayout(LINK_FIELDS)
    physics = LinkPhysics()
    physics.reset(np.arange(1), np.array([[0.3]]), np.array([[-2.0]]))
    assert layout.size == physics.measurement_size
    parts = layout.split(physics.measurement[0])
    np.testing.assert_array_equal([parts["joint_position"][0], parts["joint_velocity"][0]], [0.3, -2.0])
