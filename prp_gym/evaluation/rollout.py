"""A recorded episode, and the protocol of policies."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import gymnasium
import numpy as np
from numpy.typing import NDArray

from prp_gym.errors import InvalidValueError
from prp_gym.robot.arrays import Array


@runtime_checkable
class Policy(Protocol):
    """Anything with Stable-Baselines3's `predict`: a baseline, a trained agent, a user's own class.

    A policy whose `predict` also takes several observations, (N, size), says so by the attribute
    `batched = True`; see `prp_gym.evaluation.policy_output.takes_batches`.
    """

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
    """One episode of T control periods.

    Attributes:
        environment_id: id of the environment.
        scenario: name of the scenario.
        seed: random seed with which the episode was reset.
        period: time between torques: the control period, or that of the inner controller of an action mode
            [s].
        duration: length that the episode has unless it diverges [s].
        fields: ground truth by field name (T + 1, size), the first row from the reset; the fields of the
            observation, without sensor errors, and those from which the task computes its reward.
        torque: commanded torques within the actuator limits (T, joints) [N m, N, N m].
        applied_torque: torques that acted on the joints (T, joints), with the scenario's actuation delay and
            noise [N m, N, N m].
        reward: sum of the reward terms in `info` (T), not changed by wrappers.
        info: numbers of `info` by name (T).
        diverged: whether the episode ended in a divergence.
        compute_time: time that the policy took for an action, for some or all actions [s]; the only part
            that is not reproducible. It includes the inner controller of an action mode, over all periods of
            the action.
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
    def planned_periods(self) -> int:
        """Number of control periods T of the episode unless it diverges."""
        return round(self.duration / self.period)

    @property
    def time(self) -> Array:
        """Times of the observations (T + 1) [s]."""
        return np.arange(len(self.reward) + 1, dtype=np.float64) * float(self.period)


def inner_time(loop: Any) -> float:
    """How long the inner controller of an action mode takes for one action of one environment [s].

    Args:
        loop: control loop of an environment; 0 of one whose actions are torques.
    """
    measure = getattr(loop, "inner_time", None)
    return 0.0 if measure is None else float(measure())


def check_environment(env: gymnasium.Env[Any, Any]) -> gymnasium.Env[Any, Any]:
    """The environment itself, without its wrappers.

    Raises:
        InvalidValueError: an environment of another suite.
    """
    inner = env.unwrapped
    if not hasattr(inner, "observation_layout"):
        raise InvalidValueError("env", env, "an environment of prp_gym")
    return inner
