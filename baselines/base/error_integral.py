"""The integral action that an inverse-dynamics controller may add to the acceleration that it commands."""

from abc import ABC, abstractmethod

import numpy as np

from prp_gym.baselines.base.policy import ControllerState
from prp_gym.robot.arrays import Array


class ErrorIntegral(ABC):
    """K_I ∫e dt beside a controller's proportional and derivative action."""

    @staticmethod
    def of(gain: Array, period: float) -> "ErrorIntegral":
        """The integral action of a gain; none, and no state, where the gain is zero on every axis.

        Args:
            gain: K_I (axes) [1/s^3].
            period: control period [s].
        """
        return RunningIntegral(gain, period) if np.count_nonzero(gain) else _NO_INTEGRAL

    @abstractmethod
    def begin(self, error_shape: tuple[int, ...]) -> ControllerState:
        """The state at the start of an episode, for errors of a shape (..., axes)."""

    @abstractmethod
    def step(
        self, acceleration: Array, error: Array, state: ControllerState
    ) -> tuple[Array, ControllerState]:
        """One control period.

        Args:
            acceleration: acceleration (..., axes) of the proportional and derivative action.
            error: e (..., axes).
            state: state from `begin` or from the last call.

        Returns:
            the acceleration with K_I ∫e dt up to now, and the state a period later.
        """


class NoIntegral(ErrorIntegral):
    """No integral action."""

    def begin(self, error_shape: tuple[int, ...]) -> ControllerState:
        """No state."""
        return ()

    def step(
        self, acceleration: Array, error: Array, state: ControllerState
    ) -> tuple[Array, ControllerState]:
        """The acceleration as it is."""
        return acceleration, state


_NO_INTEGRAL = NoIntegral()
"""Shared, since it holds nothing."""


class RunningIntegral(ErrorIntegral):
    """K_I ∫e dt as the only state array.

    Args:
        gain: K_I (axes) [1/s^3].
        period: control period [s].
    """

    def __init__(self, gain: Array, period: float) -> None:
        self._gain_per_period = period * gain

    def begin(self, error_shape: tuple[int, ...]) -> ControllerState:
        """K_I ∫e dt = 0."""
        return (np.zeros(error_shape),)

    def step(
        self, acceleration: Array, error: Array, state: ControllerState
    ) -> tuple[Array, ControllerState]:
        """See `ErrorIntegral.step`."""
        (integral,) = state
        return acceleration + integral, (integral + self._gain_per_period * error,)
