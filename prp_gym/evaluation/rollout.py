"""A recorded episode, and who may play one."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import gymnasium
import numpy as np
from numpy.typing import NDArray

from prp_gym.errors import InvalidValueError
from prp_gym.robot.arrays import Array


class Policy(Protocol):
    """Whatever has Stable-Baselines3's `predict`: a baseline, a trained agent."""

    def predict(
        self,
        observation: NDArray[Any],
        state: Any = None,
        episode_start: NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[NDArray[Any], Any]:
        """The action for an observation, and the policy's state for the next call."""


@dataclass(frozen=True, eq=False)
class Rollout:
    """One episode of T periods.

    Attributes:
        environment_id: of the environment.
        scenario: its scenario.
        seed: with which the episode was reset.
        period: of the torques: that of control, or of the inner law where there is one [s].
        duration: that the episode was to have [s].
        fields: what was true, by field name (T + 1, size), the first row from the reset; those of the
            observation, without the errors of sensors, and those that the task judges by.
        torque: commanded torques within the actuator limits (T, joints) [N m, N, N m].
        applied_torque: torques that acted, late and noisy where the scenario says so (T, joints).
        reward: (T), the sum of the reward terms in `info`, whatever a wrapper makes of it [s].
        info: numbers of `info` by name (T).
        diverged: whether the episode ended in a divergence.
        compute_time: of the policy for one action, some or all of them [s]; the only part that is not
            reproducible. What an inner law takes is not in it.
    """

    environment_id: str
    scenario: str
    seed: int
    period: float
    duration: float
    fields: Mapping[str, Array]
    torque: Array
    applied_torque: Array
    reward: Array
    info: Mapping[str, Array]
    diverged: bool
    compute_time: Array

    @property
    def time(self) -> Array:
        """(T + 1) of the observations [s]."""
        return np.arange(len(self.reward) + 1, dtype=np.float64) * float(self.period)


def check_environment(env: gymnasium.Env[Any, Any]) -> gymnasium.Env[Any, Any]:
    """The environment itself, without its wrappers.

    Raises:
        InvalidValueError: an environment of another suite.
    """
    inner = env.unwrapped
    if not hasattr(inner, "observation_layout"):
        raise InvalidValueError("env", env, "an environment of prp_gym")
    return inner
