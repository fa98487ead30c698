"""From the truth to what is observed: exact, or with an imperfect force sensor."""

from abc import ABC, abstractmethod
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from prp_gym.robot.arrays import Array
from prp_gym.tasks.fields import ObservationLayout
from prp_gym.tasks.scenario import Scenario

_BLOCK = 256  # readings of noise drawn at once for an environment; part of what a seed means
_STREAM = 1  # beside the drives' stream of the same seed
_FORCE = "contact_force"


class Sensors(ABC):
    """The sensors of N robots."""

    @abstractmethod
    def begin(self, ids: NDArray[np.intp], seeds: Sequence[int]) -> None:
        """Start anew in some environments (n), with a seed each for what is random."""

    @abstractmethod
    def advance(self) -> None:
        """Go on by one period."""

    @abstractmethod
    def read(self, observation: Array) -> None:
        """Turn true values (N, size) into readings, in place; the same ones until the next `advance`."""


class IdealSensors(Sensors):
    """What is true is read."""

    def begin(self, ids: NDArray[np.intp], seeds: Sequence[int]) -> None:
        """Nothing to start."""

    def advance(self) -> None:
        """Nothing changes."""

    def read(self, observation: Array) -> None:
        """As it is."""


class NoisyForceSensor(Sensors):
    """The contact force is read with a constant error and white noise on each axis.

    An environment's errors depend on its seed and its own step count alone, not on its neighbours.

    Args:
        scenario: largest constant error and deviation of the noise.
        place: of the contact force in an observation.
        num_envs: N.
    """

    def __init__(self, scenario: Scenario, place: slice, num_envs: int) -> None:
        self._deviation, self._largest_bias = scenario.force_noise, scenario.force_bias
        self._place = place
        self._bias = np.zeros((num_envs, 3))
        self._noise = np.zeros((_BLOCK, num_envs, 3))
        self._steps = np.zeros(num_envs, dtype=np.intp)
        self._rngs = [np.random.default_rng(0) for _ in range(num_envs)]
        self._rows = np.arange(num_envs)

    def begin(self, ids: NDArray[np.intp], seeds: Sequence[int]) -> None:
        """Draw the constant errors and the first block of noise."""
        self._steps[ids] = 0
        for index, seed in zip(ids, seeds, strict=True):
            self._rngs[index] = np.random.default_rng((seed, _STREAM))
            self._bias[index] = self._rngs[index].uniform(-self._largest_bias, self._largest_bias, 3)
            self._refill(index)

    def advance(self) -> None:
        """On to the next reading of each environment."""
        self._steps += 1
        for index in np.flatnonzero(self._steps % _BLOCK == 0):
            self._refill(index)

    def read(self, observation: Array) -> None:
        """Constant error and noise on top of the contact force."""
        noise = self._noise[self._steps % _BLOCK, self._rows]
        observation[:, self._place] += self._bias + noise

    def _refill(self, index: np.intp) -> None:
        self._noise[:, index] = self._deviation * self._rngs[index].standard_normal((_BLOCK, 3))


def make_sensors(scenario: Scenario, layout: ObservationLayout, num_envs: int) -> Sensors:
    """The sensors that a scenario asks for, as far as the observation has what they disturb."""
    perfect = scenario.force_noise == 0.0 and scenario.force_bias == 0.0
    if perfect or _FORCE not in layout.names:
        return IdealSensors()
    return NoisyForceSensor(scenario, layout.index(_FORCE), num_envs)
