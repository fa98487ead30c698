"""The URDF document, read by Pinocchio, is the arm built by hand; its visual shapes lie on its masses."""

import dataclasses
import math
import xml.etree.ElementTree as ElementTree
from typing import Any

import numpy as np
import pytest

from prp_gym.robot import NOMINAL, RobotParameters, to_urdf
from tests.support.pinocchio_model import Array, PinocchioArm, Vector3, per_row, random_arm, random_states

pin: Any = pytest.importorskip("pinocchio")

ROUNDING = 1e-12  # forces up to about 100, a few dozen operations of 1e-16 each
FRICTION = dataclasses.replace(NOMINAL, viscous_friction=(0.5, 2.0, 0.1), coulomb_friction=(0.3, 1.5, 0.05))
GRAVITY = {"nominal": 9.81, "random": 3.7}
ARMS = {
    "nominal": (NOMINAL, PinocchioArm()),
    "random": random_arm(0),
}
EVERY_ARM = pytest.mark.parametrize("name", ARMS)


class ReadBack:
    """Pinocchio's model of a URDF document."""

    def __init__(self, document: str, gravity: float) -> None:
        self.model = pin.buildModelFromXML(document)
        self.model.gravity.linear = np.array([0.0, 0.0, -gravity])
        self.data = self.model.createData()

    def tip(self, q: Array) -> Array:
        pin.framesForwardKinematics(self.model, self.data, q)
        return np.array(self.data.oMf[self.model.getFrameId("tip")].translation)

    def link_rotation(self, q: Array, link: str) -> Array:
        pin.framesForwardKinematics(self.model, self.data, q)
        return np.array(self.data.oMf[self.model.getFrameId(link)].rotation)

    def inertia_matrix(self, q: Array) -> Array:
        upper = np.triu(pin.crba(self.model, self.data, q))
        return np.asarray(upper + np.triu(upper, 1).T)

    def inverse_dynamics(self, q: Array, velocity: Array, acceleration: Array) -> Array:
        return np.array(pin.rnea(self.model, self.data, q, velocity, acceleration))


def read(name: str) -> tuple[ReadBack, PinocchioArm]:
    parameters, oracle = ARMS[name]
    return ReadBack(to_urdf(parameters), GRAVITY[name]), oracle


def numbers(text: str | None) -> Array:
    assert text is not None
    return np.array([float(word) for word in text.split()])


@EVERY_ARM
def test_torques_are_those_of_the_arm_built_by_hand(name: str) -> None:
    arm, oracle = read(name)
    q, velocity, acceleration, _ = random_states(0, 50)
    expected = per_row(oracle.inverse_dynamics, q, velocity, acceleration, np.zeros((50, 3)))
    found = per_row(arm.inverse_dynamics, q, velocity, acceleration)
    np.testing.assert_allclose(found, expected, rtol=0, atol=ROUNDING)


@EVERY_ARM
def test_inertia_matrix_is_that_of_the_arm_built_by_hand(name: str) -> None:
    arm, oracle = read(name)
    q = random_states(1, 50)[0]
    expected = per_row(oracle.inertia_matrix, q)
    np.testing.assert_allclose(per_row(arm.inertia_matrix, q), expected, rtol=0, atol=ROUNDING)


@EVERY_ARM
def test_tip_is_that_of_the_arm_built_by_hand(name: str) -> None:
    arm, oracle = read(name)
    q = random_states(2, 50)[0]
    expected = per_row(oracle.tip_transform, q)[:, :3, 3]
    np.testing.assert_allclose(per_row(arm.tip, q), expected, rtol=0, atol=ROUNDING)


@EVERY_ARM
def test_centers_of_mass_are_those_of_the_arm_built_by_hand(name: str) -> None:
    arm, oracle = read(name)
    for q in random_states(3, 10)[0]:
        found = pin.centerOfMass(arm.model, arm.data, q)
        expected = pin.centerOfMass(oracle.model, oracle.model.createData(), q)
        np.testing.assert_allclose(found, expected, rtol=0, atol=ROUNDING)


def test_link_frames_coincide_with_the_worlds_axes_at_home() -> None:
    arm, _ = read("nominal")
    for link in ("link_1", "link_2", "link_3", "tip"):
        np.testing.assert_allclose(arm.link_rotation(np.zeros(3), link), np.eye(3), rtol=0, atol=ROUNDING)


def test_joints_and_links_have_the_documented_names() -> None:
    model = read("nominal")[0].model
    assert list(model.names) == ["universe", "joint_1", "joint_2", "joint_3"]
    frames = {frame.name for frame in model.frames}
    assert {"base", "link_1", "link_2", "link_3", "tip", "tip_joint"} <= frames


def test_limits_and_frictions_are_those_of_the_parameters() -> None:
    model = ReadBack(to_urdf(FRICTION), 9.81).model
    np.testing.assert_array_equal(model.lowerPositionLimit, FRICTION.joint_lower)
    np.testing.assert_array_equal(model.upperPositionLimit, FRICTION.joint_upper)
    np.testing.assert_array_equal(model.upperEffortLimit, FRICTION.torque_limit)
    np.testing.assert_array_equal(model.damping, FRICTION.viscous_friction)
    np.testing.assert_array_equal(model.upperDryFrictionLimit, FRICTION.coulomb_friction)


def test_velocity_limit_is_above_any_motion_of_the_arm() -> None:
    assert (read("nominal")[0].model.upperVelocityLimit >= 1000.0).all()


def visual(document: str, link: str) -> tuple[Array, Array, ElementTree.Element]:
    """A link's drawn shape: position, rotation and element."""
    drawn = ElementTree.fromstring(document.split("\n", 1)[1]).find(f"./link[@name='{link}']/visual")
    assert drawn is not None
    origin, geometry = drawn.find("origin"), drawn.find("geometry")
    assert origin is not None
    assert geometry is not None
    turn = numbers(origin.get("rpy"))
    return numbers(origin.get("xyz")), np.array(pin.rpy.rpyToMatrix(*turn)), geometry[0]


@pytest.mark.parametrize("name", ARMS)
@pytest.mark.parametrize(("link", "axis"), [("link_1", (1.0, 0.0, 0.0)), ("link_3", (0.0, 1.0, 0.0))])
def test_cylinders_are_drawn_along_their_links(name: str, link: str, axis: Vector3) -> None:
    parameters = ARMS[name][0]
    _, rotation, shape = visual(to_urdf(parameters), link)
    geometry = parameters.geometry
    sizes = {
        "link_1": (geometry.first_link_radius, geometry.first_link_cylinder_length),
        "link_3": (geometry.third_link_radius, geometry.third_link_cylinder_length),
    }
    assert shape.tag == "cylinder"
    assert (float(shape.get("radius", "0")), float(shape.get("length", "0"))) == sizes[link]
    np.testing.assert_allclose(np.abs(rotation[:, 2]), axis, rtol=0, atol=ROUNDING)


def test_box_is_drawn_with_its_long_side_along_the_slide() -> None:
    parameters = ARMS["random"][0]
    geometry = parameters.geometry
    _, rotation, shape = visual(to_urdf(parameters), "link_2")
    sides = (geometry.second_link_width, geometry.second_link_length, geometry.second_link_height)
    assert shape.tag == "box"
    np.testing.assert_array_equal(numbers(shape.get("size")), sides)
    np.testing.assert_array_equal(rotation, np.eye(3))


@pytest.mark.parametrize("name", ARMS)
def test_shapes_are_drawn_about_the_centers_of_mass(name: str) -> None:
    arm, _ = read(name)
    for joint, link in enumerate(("link_1", "link_2", "link_3"), start=1):
        position, _, _ = visual(to_urdf(ARMS[name][0]), link)
        np.testing.assert_allclose(position, arm.model.inertias[joint].lever, rtol=0, atol=ROUNDING)


def test_drawn_solids_of_the_density_have_the_declared_inertias() -> None:
    model = read("nominal")[0].model
    for joint, link in enumerate(("link_1", "link_2", "link_3"), start=1):
        _, rotation, shape = visual(to_urdf(), link)
        mass = model.inertias[joint].mass
        if shape.tag == "box":
            solid = pin.Inertia.FromBox(mass, *numbers(shape.get("size")))
        else:
            solid = pin.Inertia.FromCylinder(
                mass, float(shape.get("radius", "0")), float(shape.get("length", "0"))
            )
        turned = rotation @ solid.inertia @ rotation.T
        np.testing.assert_allclose(model.inertias[joint].inertia, turned, rtol=0, atol=ROUNDING)


def test_nominal_arm_is_the_default_and_numbers_keep_all_digits() -> None:
    assert to_urdf() == to_urdf(NOMINAL)
    third = RobotParameters(gravity=9.81, torque_limit=(1 / 3, 100.0, math.pi))
    assert repr(1 / 3) in to_urdf(third)
    assert to_urdf(third) != to_urdf()
