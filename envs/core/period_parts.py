"""`PeriodParts`: the parts whose formulas make up a control period."""

import copy
from typing import NamedTuple, Self

from prp_gym.envs.core.actuators import Actuators
from prp_gym.envs.core.sensors import Sensors
from prp_gym.envs.core.step_scoring import StepScoring
from prp_gym.robot.arrays import Array
from prp_gym.tasks.parts import ErrorFunction


class PeriodParts(NamedTuple):
    """The parts of a control period, besides the physics.

    Attributes:
        errors: Error function of the task.
        actuators: Actuators.
        sensors: Sensors.
        scoring: Reward, costs and `info`.
        torque_limit: Joint torques at action 1 (joints) [N m, N, N m].
    """

    errors: ErrorFunction
    actuators: Actuators
    sensors: Sensors
    scoring: StepScoring
    torque_limit: Array

    @property
    def owners(self) -> tuple[ErrorFunction, Actuators]:
        """The parts that keep numbers from one period to the next."""
        return self.errors, self.actuators

    def without_noise(self) -> Self:
        """Copies that hold no random numbers, and whose attributes may be replaced."""
        return type(self)(
            copy.copy(self.errors),
            self.actuators.without_noise(),
            self.sensors.without_noise(),
            self.scoring,
            self.torque_limit,
        )
