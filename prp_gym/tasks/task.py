"""What a task is: how an episode starts, what is observed and rewarded, and what is drawn."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from prp_gym.physics.rendering import Mark
from prp_gym.robot.arm import PRPArm
from prp_gym.robot.arrays import Array
from prp_gym.tasks.fields import MEASURED_FIELDS, Field, ObservationLayout
from prp_gym.tasks.reward import RewardTerm
from prp_gym.tasks.scenario import Range, Scenario


@dataclass(frozen=True, eq=False)
class EpisodeStart:
    """How one episode of one environment starts.

    Attributes:
        joint_position: (3) [rad, m, rad].
        joint_velocity: (3) [rad/s, m/s, rad/s].
    """

    joint_position: Array
    joint_velocity: Array


@dataclass(frozen=True)
class TaskNumbers:
    """A task's numbers, as they stand in its data file.

    Attributes:
        reward: the reward's terms.
        ranges: by name of a draw (`report`, `randomized`), from which starts and goals are drawn.
    """

    reward: tuple[RewardTerm, ...]
    ranges: Mapping[str, Mapping[str, Range]]


@dataclass(frozen=True)
class NoOptions:
    """The keywords of a task that has none of its own."""


StartT = TypeVar("StartT", bound=EpisodeStart)


class Task(ABC, Generic[StartT]):
    """The goal of N environments at once: it judges, and neither counts time nor moves the arm.

    Args:
        numbers: from the task's data file.
        scenario: the conditions of the episodes.
        arm: the nominal arm.
        options: the task's own keywords.

    Attributes:
        environment_id: under which Gymnasium knows the task.
        reference_fields: what is observed beside the measurements.
        reset_options: names that `reset(options=...)` takes.
    """

    environment_id: ClassVar[str]
    reference_fields: ClassVar[tuple[Field, ...]]
    reset_options: ClassVar[tuple[str, ...]]

    def __init__(self, numbers: TaskNumbers, scenario: Scenario, arm: PRPArm, options: object) -> None:
        self.numbers = numbers
        self.scenario = scenario
        self.arm = arm
        self.options = options
        self.layout = ObservationLayout((*MEASURED_FIELDS, *self.reference_fields))

    @abstractmethod
    def draw(self, rng: np.random.Generator, options: Mapping[str, Array]) -> StartT:
        """Draw how one episode starts.

        Args:
            rng: the environment's own generator; the same draws are made whatever the options.
            options: validated values, by names of `reset_options`, that replace what was drawn.

        Returns:
            the start.

        Raises:
            JointLimitError: a start or goal outside the joint limits.
        """

    @abstractmethod
    def begin(self, ids: NDArray[np.intp], starts: Sequence[StartT]) -> None:
        """Take up new episodes in some environments (n), the rest untouched.

        The first call covers every environment.
        """

    @abstractmethod
    def reference(self, time: Array, ids: NDArray[np.intp] | None = None) -> Array:
        """The reference part of the observations.

        Args:
            time: (..., n) since the start of each episode [s].
            ids: (n) the environments, or None for all.

        Returns:
            (..., n, size of the reference fields).
        """

    @abstractmethod
    def errors(self, observation: Array, torque: Array) -> Array:
        """The errors that the reward's terms judge, in the terms' order and units.

        Args:
            observation: (..., layout.size), after the step.
            torque: (..., 3) commanded torque, within the actuator limits [N m, N, N m].

        Returns:
            (..., terms, width), width that of the longest term; the rest of a shorter one is zero.
        """

    @abstractmethod
    def marks(self, index: int, duration: float) -> list[Mark]:
        """What to draw for one environment: goal and reference path, over a duration [s]."""
