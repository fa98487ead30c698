"""The arm as URDF for other robotics tools, generated from the same parameters as the other models."""

import math
import xml.etree.ElementTree as ElementTree

from prp_gym.robot.parameters import NOMINAL, RobotParameters, Vector3

_JOINT_TYPES = ("revolute", "prismatic", "revolute")
_AXES = ("0 0 1", "0 -1 0", "-1 0 0")
_VELOCITY_LIMIT = "1000"  # required by the format; the parameters declare no velocity limit [rad/s, m/s]
_ALONG_X = f"0 {math.pi / 2!r} 0"
_ALONG_Y = f"{math.pi / 2!r} 0 0"


def _numbers(values: Vector3) -> str:
    return " ".join(repr(float(value)) for value in values)


def _link(
    robot: ElementTree.Element, name: str, mass: float, center: Vector3, moments: Vector3
) -> ElementTree.Element:
    link = ElementTree.SubElement(robot, "link", name=name)
    inertial = ElementTree.SubElement(link, "inertial")
    ElementTree.SubElement(inertial, "origin", xyz=_numbers(center), rpy="0 0 0")
    ElementTree.SubElement(inertial, "mass", value=repr(mass))
    ixx, iyy, izz = (repr(moment) for moment in moments)
    ElementTree.SubElement(inertial, "inertia", ixx=ixx, iyy=iyy, izz=izz, ixy="0", ixz="0", iyz="0")
    return link


def _visual(link: ElementTree.Element, center: Vector3, turn: str, shape: str, **size: str) -> None:
    visual = ElementTree.SubElement(link, "visual")
    ElementTree.SubElement(visual, "origin", xyz=_numbers(center), rpy=turn)
    ElementTree.SubElement(ElementTree.SubElement(visual, "geometry"), shape, size)


def to_urdf(parameters: RobotParameters = NOMINAL) -> str:
    """The arm as a URDF document.

    Links `base`, `link_1`, `link_2`, `link_3`, `tip`; joints `joint_1`, `joint_2`, `joint_3` and the
    fixed `tip_joint`. Link frames coincide in orientation with the world frame at q = 0. Lengths [m],
    masses [kg], inertias about the centres of mass [kg m^2].

    Args:
        parameters: Parameters of the arm.

    Returns:
        Text of the document.
    """
    robot = ElementTree.Element("robot", name="prp")
    ElementTree.SubElement(robot, "link", name="base")
    _add_links(robot, parameters)
    ElementTree.SubElement(robot, "link", name="tip")
    _add_joints(robot, parameters)
    ElementTree.indent(robot)
    return '<?xml version="1.0"?>\n' + ElementTree.tostring(robot, encoding="unicode") + "\n"


def _add_links(robot: ElementTree.Element, parameters: RobotParameters) -> None:
    geometry = parameters.geometry
    centers = (
        (geometry.first_link_center_of_mass, 0.0, 0.0),
        (0.0, geometry.second_link_center_of_mass, 0.0),
        (0.0, -geometry.third_link_center_of_mass, 0.0),
    )
    links = [
        _link(robot, f"link_{i + 1}", parameters.link_mass[i], centers[i], parameters.link_inertia[i])
        for i in range(3)
    ]
    first = {"radius": repr(geometry.first_link_radius), "length": repr(geometry.first_link_cylinder_length)}
    third = {"radius": repr(geometry.third_link_radius), "length": repr(geometry.third_link_cylinder_length)}
    box = (geometry.second_link_width, geometry.second_link_length, geometry.second_link_height)
    _visual(links[0], centers[0], _ALONG_X, "cylinder", **first)
    _visual(links[1], centers[1], "0 0 0", "box", size=_numbers(box))
    _visual(links[2], centers[2], _ALONG_Y, "cylinder", **third)


def _add_joints(robot: ElementTree.Element, parameters: RobotParameters) -> None:
    geometry = parameters.geometry
    origins = (
        (0.0, 0.0, geometry.base_height),
        (geometry.first_link_offset, -geometry.slide_offset, 0.0),
        (0.0, 0.0, 0.0),
    )
    names = ("base", "link_1", "link_2", "link_3")
    for i in range(3):
        joint = ElementTree.SubElement(robot, "joint", name=f"joint_{i + 1}", type=_JOINT_TYPES[i])
        _connect(joint, names[i], names[i + 1], origins[i])
        ElementTree.SubElement(joint, "axis", xyz=_AXES[i])
        limit = {
            "lower": repr(parameters.joint_lower[i]),
            "upper": repr(parameters.joint_upper[i]),
            "effort": repr(parameters.torque_limit[i]),
            "velocity": _VELOCITY_LIMIT,
        }
        ElementTree.SubElement(joint, "limit", limit)
        friction = {
            "damping": repr(parameters.viscous_friction[i]),
            "friction": repr(parameters.coulomb_friction[i]),
        }
        ElementTree.SubElement(joint, "dynamics", friction)
    tip = ElementTree.SubElement(robot, "joint", name="tip_joint", type="fixed")
    _connect(tip, "link_3", "tip", (0.0, -geometry.third_link_length, 0.0))


def _connect(joint: ElementTree.Element, parent: str, child: str, origin: Vector3) -> None:
    ElementTree.SubElement(joint, "parent", link=parent)
    ElementTree.SubElement(joint, "child", link=child)
    ElementTree.SubElement(joint, "origin", xyz=_numbers(origin), rpy="0 0 0")
