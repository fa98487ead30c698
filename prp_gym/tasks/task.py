"""What a task is: how an episode starts, what is observed and rewarded, and what is drawn."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from prp_gym.physics.batch_simulation import Simulation
from prp_gym.physics.rendering import OverlayItem
from prp_gym.robot.arm import PRPArm
from prp_gym.robot.arrays import Array
from prp_gym.robot.link import Link
from prp_gym.tasks.fields import MEASURED_FIELDS, Field, ObservationLayout
from prp_gym.tasks.reward import RewardTerm
from prp_gym.tasks.scenario import Range, Scenario


@dataclass(frozen=True, eq=False)
class EpisodeStart:
    """How one episode of one environment starts.

    Attributes:
        joint_position: (joints) [rad, m, rad].
        joint_velocity: (joints) per second.
    """

    joint_position: Array
    joint_velocity: Array


@dataclass(frozen=True)
class ResetOption:
    """A value that `reset(options=...)` takes in place of what is drawn.

    Attributes:
        shape: () or (size,).
        unit: of its components.
        description: what it is.
    """

    shape: tuple[int, ...]
    unit: str
    description: str


@dataclass(frozen=True)
class TaskNumbers:
    """A task's numbers, as they stand in its data file.

    Attributes:
        reward: the reward's terms.
        ranges: by name of a draw (`report`, `randomized`), from which starts and goals are drawn.
        constants: other numbers by name, with their units in the data file.
    """

    reward: tuple[RewardTerm, ...]
    ranges: Mapping[str, Mapping[str, Range]]
    constants: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class NoOptions:
    """The keywords of a task that has none of its own."""


StartT = TypeVar("StartT", bound=EpisodeStart)


class Task(ABC, Generic[StartT]):
    """The goal of N environments at once: it judges, and neither counts time nor moves the robot.

    Args:
        numbers: from the task's data file.
        scenario: the conditions of the episodes.
        options: the task's own keywords.
        period: of control [s].

    Attributes:
        environment_id: under which Gymnasium knows the task.
        measured_fields: what is observed of the robot, in the order of the physics' measurement.
        reference_fields: what is observed of the goal.
        judged_fields: what is recorded and judged beside the observation, and not observed.
        reset_options: what `reset(options=...)` takes, by name.
        model: the nominal robot, whatever the plant really is.
        ranges: from which this scenario draws.
        layout: of the observation.
        ground_truth_layout: of the true values: those of the observation, and the judged fields.
    """

    environment_id: ClassVar[str]
    measured_fields: ClassVar[tuple[Field, ...]] = MEASURED_FIELDS
    reference_fields: ClassVar[tuple[Field, ...]]
    judged_fields: ClassVar[tuple[Field, ...]] = ()
    reset_options: ClassVar[Mapping[str, ResetOption]]
    model: PRPArm | Link

    def __init__(self, numbers: TaskNumbers, scenario: Scenario, options: Any, period: float) -> None:
        self.numbers = numbers
        self.scenario = scenario
        self.options = options
        self.period = period
        self.ranges: Mapping[str, Range] = numbers.ranges[scenario.draws]
        observed = (*self.measured_fields, *self.reference_fields)
        self.layout = ObservationLayout(observed)
        self.ground_truth_layout = ObservationLayout((*observed, *self.judged_fields))

    @property
    def target_impedance(self) -> Mapping[str, Array]:
        """What the robot is to behave like: `inertia`, `damping`, `stiffness` (6) of a target, or nothing."""
        return {}

    @abstractmethod
    def make_physics(self, timestep: float, num_envs: int, num_threads: int) -> Simulation:
        """The world of N environments, integrated in steps of `timestep` [s]."""

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
            InvalidValueError: another value that is not allowed.
        """

    @abstractmethod
    def draw_plant(self, rng: np.random.Generator) -> Any:
        """Draw how the robot of one episode differs from the nominal one."""

    @abstractmethod
    def place(
        self, physics: Simulation, ids: NDArray[np.intp], starts: Sequence[StartT], plants: Sequence[Any]
    ) -> None:
        """Give the worlds of some environments (n) the plants and surroundings of their new episodes."""

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

    def advance(self, ground_truth: Array) -> None:
        """Let what the task itself integrates go on by one period.

        Args:
            ground_truth: (N, truth_layout.size) at the period's end, all but the judged fields.
        """

    def complete(self, ground_truth: Array) -> None:
        """Write the judged fields into true values (N, truth_layout.size), in place."""

    @abstractmethod
    def errors(self, ground_truth: Array, torque: Array) -> Array:
        """The errors that the reward's terms judge, in the terms' order and units.

        Args:
            ground_truth: (..., truth_layout.size), after the step.
            torque: (..., joints) commanded torque, within the actuator limits [N m, N, N m].

        Returns:
            (..., terms, width), width that of the longest term; the rest of a shorter one is zero.
        """

    @abstractmethod
    def overlay(self, index: int, duration: float) -> list[OverlayItem]:
        """What to draw for one environment: goal and reference path, over a duration [s]."""
