"""From the truth to what is observed: exact, or with an imperfect force sensor."""

from abc import ABC, abstractmethod
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from prp_gym.envs.core.noise import WhiteNoise
from prp_gym.robot.arrays import Array
from prp_gym.tasks.fields import ObservationLayout
from prp_gym.tasks.scenario import Scenario

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

    Args:
        scenario: largest constant error and deviation of the noise.
        place: of the contact force in an observation.
        num_envs: N.
    """

    def __init__(self, scenario: Scenario, place: slice, num_envs: int) -> None:
        self._deviation, self._largest_bias = scenario.force_noise, scenario.force_bias
        self._place = place
        self._bias = np.zeros((num_envs, 3))
        self._noise = WhiteNoise(num_envs, 3)

    def begin(self, ids: NDArray[np.intp], seeds: Sequence[int]) -> None:
        """Draw the constant errors, and seed the noise."""
        rngs = [np.random.default_rng((seed, _STREAM)) for seed in seeds]
        for index, rng in zip(ids, rngs, strict=True):
            self._bias[index] = rng.uniform(-self._largest_bias, self._largest_bias, 3)
        self._noise.begin(ids, rngs)

    def advance(self) -> None:
        """On to the next reading of each environment."""
        self._noise.advance()

    def read(self, observation: Array) -> None:
        """Constant error and noise on top of the contact force."""
        observation[:, self._place] += self._bias + self._deviation * self._noise.current


def make_sensors(scenario: Scenario, layout: ObservationLayout, num_envs: int) -> Sensors:
    """The sensors that a scenario asks for, as far as the observation has what they disturb."""
    perfect = scenario.force_noise == 0.0 and scenario.force_bias == 0.0
    if perfect or _FORCE not in layout.names:
        return IdealSensors()
    return NoisyForceSensor(scenario, layout.index(_FORCE), num_envs)
