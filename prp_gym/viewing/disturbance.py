"""`Disturbance`: an external force at the tip or torques at the joints, for some time."""

from dataclasses import dataclass

import numpy as np

from prp_gym.checks import components, within
from prp_gym.errors import InvalidValueError
from prp_gym.robot.arm import PRPArm
from prp_gym.robot.arrays import Array, apply_transposed
from prp_gym.robot.link import Link

LARGEST_FORCE = 1000.0
"""Largest magnitude of a component of the disturbance [N, or N m]."""

LONGEST = 60.0
"""Longest disturbance [s]."""

_BOUNDS = (-LARGEST_FORCE, LARGEST_FORCE)
_NO_FORCE = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Disturbance:
    """An external force at the tip and torques at the joints, constant for some time.

    Attributes:
        duration: time for which it acts, above 0 [s].
        force: force on the tip in the world frame (3) [N].
        torque: torques at the joints (joints) [N m, N, N m]; none for an empty tuple.

    Raises:
        InvalidValueError: a duration or a component out of bounds.
    """

    duration: float
    force: tuple[float, float, float] = _NO_FORCE
    torque: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        within("duration of the disturbance", self.duration, (1e-3, LONGEST), "s")
        components("force on the tip", self.force, 3, _BOUNDS, "N")
        for value in self.torque:
            within("disturbing joint torque", value, _BOUNDS, "N·m, N, N·m")

    def check(self, model: PRPArm | Link) -> None:
        """Refuse a disturbance that does not fit a robot.

        Raises:
            InvalidValueError: a force on the tip of a link, which has no pose, or torques for another number
                of joints.
        """
        if isinstance(model, Link) and any(self.force):
            raise InvalidValueError("force on the tip", self.force, "zero: the link takes torques alone", "N")
        if self.torque and len(self.torque) != model.joint_count:
            allowed = f"{model.joint_count} numbers, one for each joint"
            raise InvalidValueError("disturbing joint torques", self.torque, allowed, "N·m, N, N·m")

    def joint_torque(self, model: PRPArm | Link, joint_position: Array) -> Array:
        """The joint torques J(q)ᵀ f + τ to which the disturbance is equivalent.

        Args:
            model: robot, whose Jacobian of the tip position is J.
            joint_position: q (joints) [rad, m, rad].

        Returns:
            (joints) [N m, N, N m].

        Source: [S] 3.8.1, duality of velocities and forces.
        """
        torque = np.array(self.torque) if self.torque else np.zeros(model.joint_count)
        if isinstance(model, Link):
            return torque
        jacobian = model.analytical_jacobian(joint_position)[:3]
        return torque + apply_transposed(jacobian, np.array(self.force))
