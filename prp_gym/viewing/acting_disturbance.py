"""`ActingDisturbance`: lets a disturbance act on a simulation for its duration."""

from typing import Any

import numpy as np

from prp_gym.robot.arrays import Array
from prp_gym.viewing.disturbance import Disturbance


class ActingDisturbance:
    """The disturbance of one environment, none at first.

    Args:
        env: environment of this suite, without wrappers.
    """

    def __init__(self, env: Any) -> None:
        self._env = env
        self.end()

    def start(self, disturbance: Disturbance) -> None:
        """Let a disturbance act from now on, in place of one that is still acting.

        Raises:
            InvalidValueError: a disturbance that does not fit the robot.
        """
        disturbance.check(self._env.arm)
        self._disturbance: Disturbance | None = disturbance
        self._left = max(1, round(disturbance.duration * self._env.control_frequency))

    def end(self) -> None:
        """Forget the disturbance; a reset of the simulation ends what acts on it."""
        self._disturbance, self._left = None, 0

    def apply(self) -> Array:
        """Set what acts on the joints during the coming action.

        Returns:
            Joint torques (joints) to which the disturbance is equivalent [N m, N, N m].
        """
        physics = self._env.physics
        torque = np.zeros(physics.joint_count)
        if self._disturbance is None:
            return torque
        if self._left > 0:
            torque = self._disturbance.joint_torque(self._env.arm, physics.joint_position[0])
            self._left -= 1
        else:
            self._disturbance = None
        physics.batch.bind("qfrc_applied")[0] = torque
        return torque
