"""The arm and the one-joint link: parameters, kinematics, dynamics, and export as URDF."""

from prp_gym.robot.arm import OperationalSpaceDynamics, PRPArm
from prp_gym.robot.link import NOMINAL_LINK, Link, LinkParameters
from prp_gym.robot.parameters import (
    JOINT_UNITS,
    NOMINAL,
    REPORT,
    TORQUE_UNITS,
    ArmGeometry,
    RobotParameters,
)
from prp_gym.robot.urdf import to_urdf

__all__ = [
    "JOINT_UNITS",
    "NOMINAL",
    "NOMINAL_LINK",
    "REPORT",
    "TORQUE_UNITS",
    "ArmGeometry",
    "Link",
    "LinkParameters",
    "OperationalSpaceDynamics",
    "PRPArm",
    "RobotParameters",
    "to_urdf",
]
