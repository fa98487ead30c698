"""What a task is composed of: a world, a start sampler, a reference and an error function."""

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from prp_gym.errors import EpisodeError
from prp_gym.robot.arm import PRPArm
from prp_gym.robot.arrays import Array
from prp_gym.robot.link import Link
from prp_gym.tasks.fields import MEASURED_FIELDS, Field, ObservationLayout
from prp_gym.tasks.trajectory import Trajectory

if TYPE_CHECKING:  # with MuJoCo, which declarations do not need
    from prp_gym.drawing.overlay import OverlayItem
    from prp_gym.physics.abstract_simulation import Simulation


@dataclass(frozen=True, eq=False)
class EpisodeStart:
    """How the episodes of n environments start.

    Attributes:
        joint_position: Initial joint positions (n, joints) [rad, m, rad].
        joint_velocity: Initial joint velocities (n, joints) per second.
        trajectory: Reference trajectories of the episodes, n rows.
    """

    joint_position: Array
    joint_velocity: Array
    trajectory: Trajectory


@dataclass(frozen=True)
class ResetOption:
    """A value that `reset(options=...)` takes in place of a drawn one.

    Attributes:
        shape: Shape of the value, () or (size,).
        unit: Unit of its components.
        description: Meaning of the value.
    """

    shape: tuple[int, ...]
    unit: str
    description: str


StartT = TypeVar("StartT", bound=EpisodeStart)


class World(ABC, Generic[StartT]):
    """The robot and its surroundings.

    Attributes:
        measured_fields: Observed quantities of the robot, in the order in which the physics measures them.
        model: Nominal robot, whatever the plant of an episode is.
    """

    measured_fields: ClassVar[tuple[Field, ...]] = MEASURED_FIELDS
    model: PRPArm | Link

    @abstractmethod
    def make_physics(self, timestep: float, num_envs: int, num_threads: int) -> "Simulation":
        """The simulation of N environments, integrated in steps of `timestep` [s]."""

    @abstractmethod
    def draw_plants(self, rngs: Sequence[np.random.Generator]) -> Any:
        """Draw how the robots of n episodes differ from the nominal one, each with its own generator."""

    @abstractmethod
    def configure(self, physics: "Simulation", ids: NDArray[np.intp], start: StartT, plants: Any) -> None:
        """Set the plants and surroundings of new episodes in some simulations (n)."""


class StartSampler(ABC, Generic[StartT]):
    """Draws how episodes start.

    Attributes:
        reset_options: Values that `reset(options=...)` takes, by name.
        greatest_stiffness: Greatest stiffness of the drawn surfaces; infinite without any [N/m].
    """

    reset_options: Mapping[str, ResetOption]
    greatest_stiffness: float = math.inf

    @abstractmethod
    def draw(self, rngs: Sequence[np.random.Generator], options: Mapping[str, Array]) -> StartT:
        """Draw how n episodes start.

        Args:
            rngs: Generators of the environments (n); the same numbers are drawn whatever the options.
            options: Validated values (n, ...), by names of `reset_options`, that replace drawn ones.

        Returns:
            The starts of the episodes.

        Raises:
            JointLimitError: a start or goal outside the joint limits.
            InvalidValueError: any other value that is not allowed.
        """


class Reference(ABC):
    """The reference trajectories of N environments, and how they are observed.

    Attributes:
        fields: Observed quantities of the reference.
        state_arrays: Names of the attributes that hold numbers of the episodes besides their trajectories,
            arrays, each with its axis of environments.
    """

    fields: ClassVar[tuple[Field, ...]]
    state_arrays: ClassVar[Mapping[str, int]] = {}

    def __init__(self) -> None:
        self._trajectory: Trajectory | None = None

    @property
    def trajectory(self) -> Trajectory:
        """The reference of every environment, N rows.

        Raises:
            EpisodeError: no episode has begun.
        """
        if self._trajectory is None:
            raise EpisodeError("no episode has begun yet: call reset() first.")
        return self._trajectory

    def rows(self, ids: NDArray[np.intp] | None) -> Trajectory:
        """The references of some environments (n), or of all."""
        return self.trajectory if ids is None else self.trajectory.rows(ids)

    def begin(self, ids: NDArray[np.intp], start: Any) -> None:
        """Begin new episodes in some environments (n); the first call covers every environment."""
        if self._trajectory is None:
            self._trajectory = start.trajectory.rows(ids)
        else:
            self._trajectory.assign(ids, start.trajectory)

    @abstractmethod
    def sample(self, time: Array, ids: NDArray[np.intp] | None = None) -> Array:
        """The reference part of the observations.

        Args:
            time: Time since the start of each episode (..., n) [s].
            ids: Environments (n); None for all.

        Returns:
            Reference fields (..., n, size).
        """

    @abstractmethod
    def overlay(self, index: int, duration: float) -> list["OverlayItem"]:
        """The overlay of one environment's frames: goal and path of its reference over a duration [s]."""


class ErrorFunction(ABC):
    """The errors from which the reward terms are computed; it may integrate a model of its own.

    Attributes:
        unobserved_fields: Quantities that are recorded and used beside the observation, but not observed.
        state_arrays: Names of the attributes that hold numbers of the episodes or of their present state,
            arrays, each with its axis of environments. Compiled code knows no others.
    """

    unobserved_fields: ClassVar[tuple[Field, ...]] = ()
    state_arrays: ClassVar[Mapping[str, int]] = {}

    @property
    def target_impedance(self) -> Mapping[str, Array]:
        """Axes (6) of the target's `inertia`, `damping` and `stiffness`; empty where there is no target."""
        return {}

    def begin(self, ids: NDArray[np.intp], start: Any) -> None:  # noqa: B027 (most have no state)
        """Begin new episodes in some environments (n); the first call covers every environment."""

    def advance(self, ground_truth: Array) -> None:  # noqa: B027
        """Integrate the model of the function, if it has one, over one control period.

        Args:
            ground_truth: Ground truth (N, size) at the end of the period, all but the unobserved fields.
        """

    def complete(self, ground_truth: Array) -> None:  # noqa: B027
        """Write the unobserved fields into the ground truth (N, size), in place."""

    @abstractmethod
    def errors(self, ground_truth: Array, torque: Array) -> Array:
        """The errors of a step, in the order and units of the reward terms.

        Args:
            ground_truth: Ground truth (..., size) after the step.
            torque: Commanded torque within the actuator limits (..., joints) [N m, N, N m].

        Returns:
            Errors (..., terms, width), where width is that of the longest term; shorter ones end with zeros.
        """


@dataclass(frozen=True, eq=False)
class TaskParts:
    """The parts of which a task is composed.

    Attributes:
        world: The robot and its surroundings.
        starts: Sampler of starts.
        reference: Reference trajectories of all environments.
        errors: Error function, from which the reward is computed.
    """

    world: World[Any]
    starts: StartSampler[Any]
    reference: Reference
    errors: ErrorFunction


def observed_layout(world: World[Any], reference: Reference) -> ObservationLayout:
    """The layout of an observation: the measured fields of a world, then the fields of the reference."""
    return ObservationLayout((*world.measured_fields, *reference.fields))
