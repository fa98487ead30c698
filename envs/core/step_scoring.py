"""Reward, costs and `info` of a step of N environments."""

import copy
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from prp_gym.envs.core.info import AVERAGED, COMMON_INFO, CONTACT_INFO, InfoField
from prp_gym.robot.arrays import Array, norm, total, zeros
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
        frequency: Control frequency [Hz].
        horizon: Control periods in an episode.

    Attributes:
        info_fields: Columns of `info`.
    """

    def __init__(self, task: Task, frequency: float, horizon: int) -> None:
        self._reward = Reward(task.numbers.reward)
        terms = [
            InfoField(f"reward_{term.name}", "1", f"reward from {term.name}", AVERAGED)
            for term in self._reward.terms
        ]
        self._has_contact = "contact_force" in task.layout.names
        self._force = task.layout.slices.get("contact_force", slice(0))
        self.info_fields = (*terms, *COMMON_INFO, *(CONTACT_INFO if self._has_contact else ()))
        bound = float(task.numbers.constants.get("force_bound", np.inf))
        self._force_bound, self._frequency, self._horizon = bound, frequency, float(horizon)
        self._terms = np.s_[:, : len(terms)]
        names = [field.name for field in self.info_fields]
        self._column = {name: np.s_[:, index] for index, name in enumerate(names)}
        self._time = self._column["time"]

    def __call__(
        self,
        errors: Array,
        ground_truth: Array,
        saturated: NDArray[np.bool_] | None,
        elapsed: Array,
        stop_violation: Array | None,
    ) -> tuple[Array, Array]:
        """Score a step.

        Args:
            errors: Errors of the task (N, terms, width), in the units of the reward terms.
            ground_truth: Ground truth (N, size).
            saturated: Which actions are at or beyond the actuator limits (N, joints); None if none is.
            elapsed: Control periods since the start of each episode (N).
            stop_violation: Negative distances of joints beyond their stops (N, joints); None if none is.

        Returns:
            Reward (N) and `info` (N, fields).
        """
        info = zeros((len(errors), len(self.info_fields)), errors)
        contributions = self._reward(errors)
        info[self._terms] = contributions
        np.divide(elapsed, self._frequency, out=info[self._time])
        if saturated is not None:
            info[self._column["cost_saturation"]] = count(saturated)
        if stop_violation is not None:
            info[self._column["cost_joint_stop"]] = count(stop_violation)
        if self._has_contact:
            magnitude = norm(ground_truth[:, self._force])
            info[self._column["contact_force"]] = magnitude
            info[self._column["cost_force_bound"]] = (magnitude > self._force_bound).astype(np.float64)
        return total(contributions), info

    def truncated(self, elapsed: Array) -> NDArray[np.bool_]:
        """Whether the duration of each episode is over (N), after so many control periods (N)."""
        over: NDArray[np.bool_] = elapsed >= self._horizon
        return over

    def at_start(self, ground_truth: Array) -> Array:
        """The `info` (N, fields) at the start of an episode: the contact force there; all else is zero."""
        info = np.zeros((len(ground_truth), len(self.info_fields)))
        if self._has_contact:
            info[self._column["contact_force"]] = norm(ground_truth[:, self._force])
        return info

    def with_fresh_reward(self) -> Self:
        """A copy that has scored nothing yet, for any number of environments."""
        own = copy.copy(self)
        own._reward = Reward(self._reward.terms)
        return own

    def zero_reward(self, reward: Array, info: Array, rows: NDArray[np.bool_]) -> None:
        """Set the reward of some environments (a mask of N) and its terms in `info` to zero, in place."""
        reward[:] = np.where(rows, 0.0, reward)
        info[self._terms] = np.where(rows[:, None], 0.0, info[self._terms])
