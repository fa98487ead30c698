"""A recorded episode, and how to record one."""

import time
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
    """One episode of T steps.

    Attributes:
        environment_id: of the environment.
        scenario: its scenario.
        seed: with which the episode was reset.
        period: of control [s].
        duration: that the episode was to have [s].
        fields: what was true, by field name (T + 1, size), the first row from the reset; those of the
            observation, without the errors of sensors, and those that the task judges by.
        torque: commanded torques within the actuator limits (T, joints) [N m, N, N m].
        applied_torque: torques that acted, late and noisy where the scenario says so (T, joints).
        reward: (T), the sum of the reward terms in `info`, whatever a wrapper makes of it [s].
        info: numbers of `info` by name (T).
        diverged: whether the episode ended in a divergence.
        compute_time: of the policy for one action, some or all of them [s]; the only part that is not
            reproducible.
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


def record_episode(
    policy: Policy, env: gymnasium.Env[Any, Any], seed: int, options: dict[str, Any] | None = None
) -> Rollout:
    """Play one episode and record it.

    Args:
        policy: reads the environment's observations.
        env: an environment of this suite; wrappers must leave observations as they are.
        seed: of the episode.
        options: for `reset`.

    Returns:
        the episode.

    Raises:
        InvalidValueError: an environment of another suite.
    """
    inner = check_environment(env)
    observation, _ = env.reset(seed=seed, options=options)
    truths, torques, applied, rewards, infos, costs = [inner.get_wrapper_attr("truth")], [], [], [], [], []
    state, start, terminated, truncated = None, np.array([True]), False, False
    while not (terminated or truncated):
        before = time.perf_counter()
        action, state = policy.predict(observation, state, episode_start=start, deterministic=True)
        costs.append(time.perf_counter() - before)
        observation, _, terminated, truncated, info = env.step(action)
        start = np.array([False])
        truths.append(inner.get_wrapper_attr("truth"))
        torques.append(inner.get_wrapper_attr("commanded_torque"))
        applied.append(inner.get_wrapper_attr("applied_torque"))
        rewards.append(sum(value for name, value in info.items() if name.startswith("reward_")))
        infos.append(info)
    return Rollout(
        environment_id=inner.get_wrapper_attr("task").environment_id,
        scenario=inner.get_wrapper_attr("task").scenario.name,
        seed=seed,
        period=1.0 / inner.get_wrapper_attr("control_frequency"),
        duration=float(inner.get_wrapper_attr("duration")),
        fields=inner.get_wrapper_attr("task").truth_layout.split(np.array(truths)),
        torque=np.array(torques),
        applied_torque=np.array(applied),
        reward=np.array(rewards),
        info={name: np.array([row[name] for row in infos]) for name in infos[0]},
        diverged=terminated,
        compute_time=np.array(costs),
    )
