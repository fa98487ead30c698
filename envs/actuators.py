"""From commanded torques to the torques that act: ideal, or late and noisy."""

from abc import ABC, abstractmethod
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from prp_gym.robot.arrays import Array
from prp_gym.tasks.scenario import Scenario

_BLOCK = 256  # steps of noise drawn at once for an environment; part of what a seed means


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

    An environment's noise depends on its seed and its own step count alone, not on its neighbours.

    Args:
        scenario: delay and noise.
        nominal_limit: of the drives (joints) [N m, N, N m].
        num_envs: N.
    """

    def __init__(self, scenario: Scenario, nominal_limit: Array, num_envs: int) -> None:
        self._deviation = scenario.torque_noise * nominal_limit
        joints = len(nominal_limit)
        self._pipeline = np.zeros((scenario.delay_steps + 1, num_envs, joints))
        self._noise = np.zeros((_BLOCK, num_envs, joints))
        self._steps = np.zeros(num_envs, dtype=np.intp)
        self._rngs = [np.random.default_rng(0) for _ in range(num_envs)]
        self._rows = np.arange(num_envs)

    def begin(self, ids: NDArray[np.intp], seeds: Sequence[int]) -> None:
        """Empty the delay line and seed the noise."""
        self._pipeline[:, ids] = 0.0
        self._steps[ids] = 0
        for index, seed in zip(ids, seeds, strict=True):
            self._rngs[index] = np.random.default_rng(seed)

    def apply(self, command: Array) -> Array:
        """The command of `delay_steps` periods ago, with noise."""
        phase = self._steps % _BLOCK
        for index in np.flatnonzero(phase == 0):
            self._noise[:, index] = self._rngs[index].standard_normal((_BLOCK, len(self._deviation)))
        self._steps += 1
        self._pipeline[1:] = self._pipeline[:-1].copy()
        self._pipeline[0] = command
        late: Array = self._pipeline[-1] + self._noise[phase, self._rows] * self._deviation
        return late


def make_actuators(scenario: Scenario, nominal_limit: Array, num_envs: int) -> Actuators:
    """The drives that a scenario asks for; `nominal_limit` (joints) [N m, N, N m]."""
    if scenario.delay_steps == 0 and scenario.torque_noise == 0.0:
        return IdealActuators()
    return RealisticActuators(scenario, nominal_limit, num_envs)
