"""Sensors, which turn the ground truth into observations: exact, or with force-sensor noise and bias."""

import copy
from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from prp_gym.envs.core.noise import WhiteNoise
from prp_gym.robot.arrays import Array
from prp_gym.tasks.fields import ObservationLayout
from prp_gym.tasks.scenario import Scenario

_STREAM = 1  # random stream of an episode's seed, beside that of the actuators
_FORCE = "contact_force"


class Sensors(ABC):
    """The sensors of N robots."""

    @abstractmethod
    def begin(self, ids: NDArray[np.intp], seeds: Sequence[int]) -> None:
        """Restart the sensors of some environments (n), with a random seed for each."""

    @abstractmethod
    def advance(self) -> None:
        """Go on to the readings of the next control period."""

    @abstractmethod
    def read(self, observation: Array) -> None:
        """Turn true values (N, size) into readings, in place; errors change with `advance` only."""

    def without_noise(self) -> Self:
        """A copy of the formulas, without the random numbers."""
        return copy.copy(self)

    @abstractmethod
    def errors_ahead(self, periods: int) -> Array | None:
        """The errors (periods, N, 3) of the force in the next periods, which are over then; None for none."""

    @abstractmethod
    def disturb(self, observation: Array, error: Array | None) -> None:
        """Add errors (N, 3) of the force to true values (N, size), in place."""


class IdealSensors(Sensors):
    """Sensors that read the true values."""

    def begin(self, ids: NDArray[np.intp], seeds: Sequence[int]) -> None:
        """See `Sensors.begin`; there is no state."""

    def advance(self) -> None:
        """See `Sensors.advance`; there is no state."""

    def read(self, observation: Array) -> None:
        """See `Sensors.read`: the true values stay."""

    def without_noise(self) -> Self:
        """See `Sensors.without_noise`: they have none."""
        return self

    def errors_ahead(self, periods: int) -> Array | None:
        """See `Sensors.errors_ahead`: none."""
        return None

    def disturb(self, observation: Array, error: Array | None) -> None:
        """See `Sensors.disturb`: the true values stay."""


class NoisyForceSensor(Sensors):
    """Sensors whose contact force has a constant bias and white noise on each axis.

    Args:
        scenario: Scenario that gives the largest bias and the standard deviation of the noise.
        force_index: Slice of the contact force in an observation.
        num_envs: Number of environments N.
    """

    def __init__(self, scenario: Scenario, force_index: slice, num_envs: int) -> None:
        self._deviation, self._largest_bias = scenario.force_noise, scenario.force_bias
        self._force_index = force_index
        self._bias = np.zeros((num_envs, 3))
        self._noise = WhiteNoise(num_envs, 3)

    def begin(self, ids: NDArray[np.intp], seeds: Sequence[int]) -> None:
        """Draw the biases and seed the noise."""
        rngs = [np.random.default_rng((seed, _STREAM)) for seed in seeds]
        for index, rng in zip(ids, rngs, strict=True):
            self._bias[index] = rng.uniform(-self._largest_bias, self._largest_bias, 3)
        self._noise.begin(ids, rngs)

    def advance(self) -> None:
        """Go on to the next reading of each environment."""
        self._noise.advance()

    def read(self, observation: Array) -> None:
        """Add bias and noise to the contact force."""
        self.disturb(observation, self._bias + self._deviation * self._noise.current)

    def without_noise(self) -> Self:
        """See `Sensors.without_noise`."""
        own: Any = copy.copy(self)
        own._noise = own._bias = None
        return own  # type: ignore[no-any-return]

    def errors_ahead(self, periods: int) -> Array | None:
        """See `Sensors.errors_ahead`."""
        noise = self._noise.next_steps(periods, with_present=False)
        errors: Array = self._bias + self._deviation * noise
        return errors

    def disturb(self, observation: Array, error: Array | None) -> None:
        """See `Sensors.disturb`."""
        observation[:, self._force_index] += np.zeros(3) if error is None else error


_IDEAL = IdealSensors()  # one for all, so that compiled code is known to serve all


def make_sensors(scenario: Scenario, layout: ObservationLayout, num_envs: int) -> Sensors:
    """Make the sensors of a scenario; an observation without a contact force has no sensor errors."""
    exact = scenario.force_noise == 0.0 and scenario.force_bias == 0.0
    if exact or _FORCE not in layout.names:
        return _IDEAL
    return NoisyForceSensor(scenario, layout.index(_FORCE), num_envs)
