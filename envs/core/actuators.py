"""From commanded torques to the torques that act: ideal, or late and noisy."""

from abc import ABC, abstractmethod
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from prp_gym.envs.core.noise import WhiteNoise
from prp_gym.robot.arrays import Array
from prp_gym.tasks.scenario import Scenario


class Actuators(ABC):
    """The drives of N robots."""

    @abstractmethod
    def begin(self, ids: NDArray[np.intp], seeds: Sequence[int]) -> None:
        """Start anew in some environments (n), with a seed each for what is random."""

    @abstractmethod
    def apply(self, command: Array) -> Array:
        """The torques (N, joints) that act while these are commanded [N m, N, N m]."""


class IdealActuators(Actuators):
    """What is commanded acts."""

    def begin(self, ids: NDArray[np.intp], seeds: Sequence[int]) -> None:
        """Nothing to start."""

    def apply(self, command: Array) -> Array:
        """The command."""
        return command


class RealisticActuators(Actuators):
    """Commands act late, by whole control periods, and with white noise on top of the limited torque.

    Args:
        scenario: delay and noise.
        nominal_limit: of the drives (joints) [N m, N, N m].
        num_envs: N.
    """

    def __init__(self, scenario: Scenario, nominal_limit: Array, num_envs: int) -> None:
        self._deviation = scenario.torque_noise * nominal_limit
        self._pipeline = np.zeros((scenario.delay_steps + 1, num_envs, len(nominal_limit)))
        self._noise = WhiteNoise(num_envs, len(nominal_limit))

    def begin(self, ids: NDArray[np.intp], seeds: Sequence[int]) -> None:
        """Empty the delay line and seed the noise."""
        self._pipeline[:, ids] = 0.0
        self._noise.begin(ids, [np.random.default_rng(seed) for seed in seeds])

    def apply(self, command: Array) -> Array:
        """The command of `delay_steps` periods ago, with noise."""
        self._pipeline[1:] = self._pipeline[:-1].copy()
        self._pipeline[0] = command
        late: Array = self._pipeline[-1] + self._noise.current * self._deviation
        self._noise.advance()
        return late


def make_actuators(scenario: Scenario, nominal_limit: Array, num_envs: int) -> Actuators:
    """The drives that a scenario asks for; `nominal_limit` (joints) [N m, N, N m]."""
    if scenario.delay_steps == 0 and scenario.torque_noise == 0.0:
        return IdealActuators()
    return RealisticActuators(scenario, nominal_limit, num_envs)
