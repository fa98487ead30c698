"""The settings of every controller that reads the contact force: how its sensor is tared."""

import math
from dataclasses import dataclass
from typing import ClassVar

from prp_gym.baselines.base.settings import Settings
from prp_gym.baselines.base.taring import NoTaring, Taring, TaringUntilContact, TaringWheneverFree

TARING = ("none", "until_contact", "whenever_free")


@dataclass(frozen=True, eq=False, kw_only=True)
class ForceSensingSettings(Settings):
    """Settings of a controller that reads the contact force.

    Attributes:
        taring: `none` takes the readings as they are, `until_contact` subtracts their mean before the first
            touch, `whenever_free` subtracts a new mean whenever the tip has left the surface.
        sensor_noise: standard deviation of the force sensor's noise on each axis, above 0 [N].
        sensor_bias: largest magnitude of the force sensor's bias [N].
        least_stiffness: least stiffness of a surface, above 0, from which follows how far the tip must
            withdraw before the sensor is tared again [N/m].
        taring_time: time over which readings are averaged with `whenever_free`, above 0 [s].
    """

    taring: str = "none"
    sensor_noise: float = 0.05
    sensor_bias: float = 0.4
    least_stiffness: float = 50.0
    taring_time: float = 2.0

    numbers: ClassVar = {
        "sensor_noise": "N",
        "sensor_bias": "N",
        "least_stiffness": "N/m",
        "taring_time": "s",
    }
    choices: ClassVar = {"taring": TARING}

    held_back_time: ClassVar[float] = 0.03
    """Time before a touch whose readings are dropped [s]: 0.14 N on 5 N/m at 1.5 m/s take 0.02 s."""

    def make_taring(self, period: float) -> Taring:
        """The taring at a control period [s]."""
        if self.taring == "none":
            return NoTaring()
        noise, bias = self.sensor_noise, self.sensor_bias
        held_back = float(math.ceil(self.held_back_time / period))  # a number that compiled code takes
        if self.taring == "until_contact":
            return TaringUntilContact(noise, bias, held_back=held_back)
        count = max(self.taring_time / period, 1.0)
        return TaringWheneverFree(noise, bias, count, held_back, self.least_stiffness)
