"""Actuators, which turn commanded torques into applied ones: ideal, or with delay and noise."""

import copy
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from prp_gym.envs.core.noise import WhiteNoise
from prp_gym.robot.arrays import Array
from prp_gym.tasks.scenario import Scenario


class Actuators(ABC):
    """The actuators of N robots.

    Attributes:
        state_arrays: Names of the arrays that are kept from one period to the next, each with its axis of
            robots.
    """

    state_arrays: ClassVar[Mapping[str, int]] = {}

    @abstractmethod
    def begin(self, ids: NDArray[np.intp], seeds: Sequence[int]) -> None:
        """Restart the actuators of some environments (n), with a random seed for each."""

    @abstractmethod
    def apply(self, command: Array) -> Array:
        """The torques (N, joints) that are applied while these are commanded [N m, N, N m]."""

    def without_noise(self) -> Self:
        """A copy of the formulas and the kept arrays, without the random numbers."""
        return copy.copy(self)

    @abstractmethod
    def noise_ahead(self, periods: int) -> Array | None:
        """The noise (periods, N, joints) of the next periods, which are over then; None for none."""

    @abstractmethod
    def transmit(self, command: Array, noise: Array | None) -> Array:
        """The torques (N, joints) that are applied with a noise of this period [N m, N, N m]."""


class IdealActuators(Actuators):
    """Actuators that apply the commanded torques exactly."""

    def begin(self, ids: NDArray[np.intp], seeds: Sequence[int]) -> None:
        """See `Actuators.begin`; there is no state."""

    def apply(self, command: Array) -> Array:
        """See `Actuators.apply`: the command itself."""
        return command

    def without_noise(self) -> Self:
        """See `Actuators.without_noise`: they have none."""
        return self

    def noise_ahead(self, periods: int) -> Array | None:
        """See `Actuators.noise_ahead`: none."""
        return None

    def transmit(self, command: Array, noise: Array | None) -> Array:
        """See `Actuators.transmit`: the command itself."""
        return command


class RealisticActuators(Actuators):
    """Actuators with a delay of whole control periods and white noise on top of the limited torque.

    Args:
        scenario: Scenario that gives the delay and the noise.
        nominal_limit: Nominal actuator limits (joints) [N m, N, N m].
        num_envs: Number of environments N.
    """

    state_arrays: ClassVar[Mapping[str, int]] = {"_pipeline": 1}

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
        applied = self.transmit(command, self._noise.current * self._deviation)
        self._noise.advance()
        return applied

    def without_noise(self) -> Self:
        """See `Actuators.without_noise`."""
        own: Any = copy.copy(self)
        own._noise = None
        return own  # type: ignore[no-any-return]

    def noise_ahead(self, periods: int) -> Array | None:
        """See `Actuators.noise_ahead`."""
        return self._noise.next_steps(periods, with_present=True) * self._deviation

    def transmit(self, command: Array, noise: Array | None) -> Array:
        """See `Actuators.transmit`."""
        self._pipeline[1:] = self._pipeline[:-1].copy()
        self._pipeline[0] = command
        applied: Array = self._pipeline[-1] + noise
        return applied


_IDEAL = IdealActuators()  # one for all, so that compiled code is known to serve all


def make_actuators(scenario: Scenario, nominal_limit: Array, num_envs: int) -> Actuators:
    """Make the actuators of a scenario.

    Args:
        scenario: Scenario that gives the delay and the noise.
        nominal_limit: Nominal actuator limits (joints) [N m, N, N m].
        num_envs: Number of environments N.
    """
    if scenario.delay_steps == 0 and scenario.torque_noise == 0.0:
        return _IDEAL
    return RealisticActuators(scenario, nominal_limit, num_envs)
