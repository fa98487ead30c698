"""`SensorLayout`: which columns of a world's sensors are what."""

from typing import NamedTuple

from prp_gym.robot.arrays import Array

NO_COLUMNS = slice(0, 0)
"""Columns of a quantity that a world does not have."""


class SensorLayout(NamedTuple):
    """Layout of a world's sensors, of which joint position and joint velocity are the first.

    Attributes:
        gain: Gain (k) of the measurement, which is gain·sensors + offset for the first k sensors.
        offset: Offset (k) of the measurement.
        tip_position: Columns of the tip position.
        contact_force: Columns of the contact force, or `NO_COLUMNS` without contact.
        stop_violation: Columns of the joint stops' violation, or `NO_COLUMNS` without joint stops.
    """

    gain: Array
    offset: Array
    tip_position: slice
    contact_force: slice
    stop_violation: slice
