"""The reference of the arm, in the space in which a controller needs it."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import NamedTuple

from prp_gym.robot.arm import PRPArm
from prp_gym.robot.arrays import Array

REFERENCE_FIELDS = (
    ("desired_joint_position", "desired_joint_velocity", "desired_joint_acceleration"),
    ("desired_pose", "desired_velocity", "desired_acceleration"),
)
"""The fields of a joint-space and of an operational-space reference; an environment observes one of them."""

OFFSET_FIELDS = ("joint_offset", "pose_offset")
"""Offsets by which action modes move a reference, in its space: (joints), and x, y, z, α, β."""


class JointReference(NamedTuple):
    """A motion of the joints.

    Attributes:
        position: q_d (..., joints) [rad, m, rad].
        velocity: q̇_d (..., joints) [rad/s, m/s, rad/s].
        acceleration: q̈_d (..., joints) [rad/s^2, m/s^2, rad/s^2].
    """

    position: Array
    velocity: Array
    acceleration: Array


class PoseReference(NamedTuple):
    """A motion of the end effector.

    Attributes:
        pose: x_d (..., 6) [m, m, m, rad, rad, rad], world frame.
        velocity: ẋ_d (..., 6) per second.
        acceleration: ẍ_d (..., 6) per second squared.
    """

    pose: Array
    velocity: Array
    acceleration: Array


class References(ABC):
    """The reference of an observation, given in one space and available in both."""

    @abstractmethod
    def joint(self, observed: Mapping[str, Array]) -> JointReference:
        """The reference as a motion of the joints; fields (..., size) by name."""

    @abstractmethod
    def pose(self, observed: Mapping[str, Array], arm: PRPArm) -> PoseReference:
        """The reference as a motion of the end effector of an arm; fields (..., size) by name."""


class JointReferences(References):
    """A reference given in joint space; its pose is x_d = k(q_d), ẋ_d = J_A q̇_d, ẍ_d = J_A q̈_d + J̇_A q̇_d."""

    def joint(self, observed: Mapping[str, Array]) -> JointReference:
        """The reference as it is observed."""
        position, velocity, acceleration = (observed[name] for name in REFERENCE_FIELDS[0])
        return JointReference(position, velocity, acceleration)

    def pose(self, observed: Mapping[str, Array], arm: PRPArm) -> PoseReference:
        """The pose reference by the direct kinematics."""
        return PoseReference(*arm.pose_motion(*self.joint(observed)))


class PoseReferences(References):
    """A reference given in operational space; see `PRPArm.joint_motion` for its motion of the joints.

    Args:
        arm: model whose kinematics are inverted.
    """

    def __init__(self, arm: PRPArm) -> None:
        self._arm = arm

    def joint(self, observed: Mapping[str, Array]) -> JointReference:
        """The joint reference by the inverse kinematics."""
        return JointReference(*self._arm.joint_motion(*self.pose(observed, self._arm)))

    def pose(self, observed: Mapping[str, Array], arm: PRPArm) -> PoseReference:
        """The reference as it is observed."""
        pose, velocity, acceleration = (observed[name] for name in REFERENCE_FIELDS[1])
        return PoseReference(pose, velocity, acceleration)


class MovedReferences(References):
    """A reference moved by an offset that is observed beside it; γ, which never moves, has none.

    Args:
        given: the reference as the environment gives it.
    """

    def __init__(self, given: References) -> None:
        self._given = given

    def joint(self, observed: Mapping[str, Array]) -> JointReference:
        """The given motion, shifted by `joint_offset`."""
        motion = self._given.joint(observed)
        return motion._replace(position=motion.position + observed["joint_offset"])

    def pose(self, observed: Mapping[str, Array], arm: PRPArm) -> PoseReference:
        """The given motion, shifted by `pose_offset`."""
        motion = self._given.pose(observed, arm)
        pose, offset = motion.pose.copy(), observed["pose_offset"]
        pose[..., : offset.shape[-1]] += offset
        return motion._replace(pose=pose)
