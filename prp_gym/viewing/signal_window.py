"""`SignalWindow`: records the last seconds of an environment."""

import math
from typing import Any

import numpy as np

from prp_gym.robot.arrays import Array
from prp_gym.viewing.signals import Signals


class SignalWindow:
    """The last periods of a control loop with one environment, in a ring of rows.

    With an inner controller its periods are recorded, of which an action has several.

    Args:
        loop: control loop of one environment.
        seconds: length of the window [s].
    """

    def __init__(self, loop: Any, seconds: float) -> None:
        rows = math.ceil(seconds * loop.config.control_frequency) + 1
        self._loop = loop
        self._ground_truth = np.zeros((rows, loop.task.ground_truth_layout.size))
        self._time = np.zeros(rows)
        self._torque = np.zeros((3, rows, loop.joints))
        self._disturbance = np.zeros(loop.joints)
        self._count = 0

    def begin(self) -> None:
        """Forget everything, and record the start of an episode."""
        self._count = 0
        self._record(np.zeros((3, self._loop.joints)))

    def disturb(self, torque: Array) -> None:
        """Record joint torques (joints) [N m, N, N m] as the disturbance of the coming periods."""
        self._disturbance = np.array(torque)

    def take(self, _: object) -> None:
        """Record the period that the loop has just simulated; a listener of the loop."""
        loop = self._loop
        self._record(np.stack([loop.commanded_torque[0], loop.physics.torque[0], self._disturbance]))

    def _record(self, torques: Array) -> None:
        row = self._count % len(self._time)
        self._time[row] = self._loop.time[0]
        self._ground_truth[row] = self._loop.ground_truth[0]
        self._torque[:, row] = torques
        self._count += 1

    def signals(self) -> Signals:
        """A copy of what was recorded, in the order of time."""
        rows = len(self._time)
        order = np.arange(max(0, self._count - rows), self._count) % rows
        return Signals(
            time=self._time[order],
            fields=self._loop.task.ground_truth_layout.split(self._ground_truth[order]),
            torque=self._torque[0, order],
            applied_torque=self._torque[1, order],
            disturbance=self._torque[2, order],
            torque_limit=np.array(self._loop.torque_limit),
        )
