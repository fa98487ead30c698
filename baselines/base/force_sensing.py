"""The settings of every controller that reads the contact force: how its sensor is tared."""

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

    def make_taring(self, period: float) -> Taring:
        """The taring at a control period [s]."""
        if self.taring == "none":
            return NoTaring()
        if self.taring == "until_contact":
            return TaringUntilContact(self.sensor_noise, self.sensor_bias)
        count = max(self.taring_time / period, 1.0)
        return TaringWheneverFree(self.sensor_noise, self.sensor_bias, count, self.least_stiffness)
