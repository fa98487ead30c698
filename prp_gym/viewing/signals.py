"""`Signals`: what an environment did over the last seconds."""

from collections.abc import Mapping
from dataclasses import dataclass

from prp_gym.robot.arrays import Array


@dataclass(frozen=True, eq=False)
class Signals:
    """The signals of one environment over the last T periods of its control loop.

    The first row of an episode is its start, before any torque has acted.

    Attributes:
        time: time since the start of the episode (T) [s].
        fields: ground truth by the names of its fields (T, size).
        torque: commanded joint torques within the actuator limits (T, joints) [N m, N, N m].
        applied_torque: joint torques that acted, with the scenario's delay and noise (T, joints)
            [N m, N, N m].
        disturbance: joint torques to which the disturbance was equivalent (T, joints) [N m, N, N m].
        torque_limit: actuator limits (joints) [N m, N, N m].
    """

    time: Array
    fields: Mapping[str, Array]
    torque: Array
    applied_torque: Array
    disturbance: Array
    torque_limit: Array
