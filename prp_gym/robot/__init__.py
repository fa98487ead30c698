"""The arm: parameters, kinematics, dynamics, and its description for other tools."""

from prp_gym.robot.arm import OperationalSpaceDynamics, PRPArm
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
    "REPORT",
    "TORQUE_UNITS",
    "ArmGeometry",
    "OperationalSpaceDynamics",
    "PRPArm",
    "RobotParameters",
    "to_urdf",
]
