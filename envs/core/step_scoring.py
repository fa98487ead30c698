"""Reward, costs and `info` of a step of N environments."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from prp_gym.envs.core.info import AVERAGED, COMMON_INFO, CONTACT_INFO, InfoField
from prp_gym.physics.abstract_simulation import Simulation
from prp_gym.robot.arrays import Array, norm, total
from prp_gym.tasks.reward import Reward
from prp_gym.tasks.task import Task


def count(flags: NDArray[Any]) -> NDArray[np.intp]:
    """The number of nonzero values in each row (N, joints)."""
    counts: NDArray[np.intp] = np.count_nonzero(flags, axis=1)
    return counts


class StepScoring:
    """Computes the reward, the costs and the `info` of N environments.

    Args:
        task: Task that declares the reward terms and the fields.
        physics: Simulation of the N environments.
        frequency: Control frequency [Hz].

    Attributes:
        info_fields: Columns of `info`.
    """

    def __init__(self, task: Task, physics: Simulation, frequency: float) -> None:
        num_envs = physics.num_simulations
        self._physics = physics
        self._reward = Reward(task.numbers.reward)
        terms = [
            InfoField(f"reward_{term.name}", "1", f"reward from {term.name}", AVERAGED)
            for term in self._reward.terms
        ]
        self._has_contact = "contact_force" in task.layout.names
        self.info_fields = (*terms, *COMMON_INFO, *(CONTACT_INFO if self._has_contact else ()))
        bound = float(task.numbers.constants.get("force_bound", np.inf))
        self._force_bound = np.full(num_envs, bound)
        self._frequency = np.full(num_envs, frequency)
        self._shape = (num_envs, len(self.info_fields))
        self._terms = np.s_[:, : len(terms)]
        names = [field.name for field in self.info_fields]
        self._column = {name: np.s_[:, index] for index, name in enumerate(names)}
        self._time = self._column["time"]

    def __call__(
        self, errors: Array, saturated: NDArray[np.bool_] | None, elapsed: Array, within_limits: bool
    ) -> tuple[Array, Array]:
        """Score a step.

        Args:
            errors: Errors of the task (N, terms, width), in the units of the reward terms.
            saturated: Which actions are at or beyond the actuator limits (N, joints); None if none is.
            elapsed: Control periods since the start of each episode (N).
            within_limits: Whether no joint is beyond its stop.

        Returns:
            Reward (N) and `info` (N, fields).
        """
        info = np.zeros(self._shape)
        contributions = self._reward(errors)
        info[self._terms] = contributions
        np.divide(elapsed, self._frequency, out=info[self._time])
        if saturated is not None:
            info[self._column["cost_saturation"]] = count(saturated)
        if not within_limits:
            info[self._column["cost_joint_stop"]] = count(self._physics.stop_violation)
        if self._has_contact:
            self._add_contact(info)
        return total(contributions), info

    def at_start(self) -> Array:
        """The `info` (N, fields) at the start of an episode: the contact force there; all else is zero."""
        info = np.zeros(self._shape)
        if self._has_contact:
            info[self._column["contact_force"]] = self._contact_force()
        return info

    def _contact_force(self) -> Array:
        """Magnitude of the contact force of each environment (N) [N]."""
        force = self._physics.contact_force
        magnitude: Array = norm(force)
        return magnitude

    def _add_contact(self, info: Array) -> None:
        magnitude = self._contact_force()
        info[self._column["contact_force"]] = magnitude
        info[self._column["cost_force_bound"]] = magnitude > self._force_bound

    def zero_reward(self, reward: Array, info: Array, rows: NDArray[np.bool_]) -> None:
        """Set the reward of some environments (a mask of N) and its terms in `info` to zero, in place."""
        reward[rows] = 0.0
        info[rows, self._terms[1]] = 0.0
