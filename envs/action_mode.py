"""Action modes: the declared fields of an action, its conversion to joint torques, and the registry."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from prp_gym.checks import choice, instance
from prp_gym.errors import InvalidValueError
from prp_gym.registry import NOT_IN_THE_REPORT, Registry
from prp_gym.robot.arrays import Array, elementwise
from prp_gym.robot.parameters import TORQUE_UNITS
from prp_gym.tasks.fields import ObservationLayout

TORQUE = "torque"
"""The mode in which an action is the joint torques normalised by the actuator limits."""

INNER_FREQUENCY = 500.0
"""Control frequency of the inner controller of every other mode [Hz], at any frequency of the actions."""

ANY_CONTROLLER = "<controller>"
"""Controller's name of a family of modes, which has one mode for each controller."""


@dataclass(frozen=True)
class ActionField:
    """One named part of an action, whose components lie in [-1, 1].

    Attributes:
        name: name of the field.
        units: unit of each component; their number is the field's size.
        frame: frame in which the components are expressed.
        bound: value (size) that an action of 1 commands, in the units; above 0, or above 1 for a factor.
        description: meaning of the field, as tables print it.
        factor: whether an action a commands bound^a, from 1/bound to bound, instead of bound·a.
    """

    name: str
    units: tuple[str, ...]
    frame: str
    bound: tuple[float, ...]
    description: str
    factor: bool = False

    def __post_init__(self) -> None:
        least = 1.0 if self.factor else 0.0
        if len(self.bound) != len(self.units) or not all(value > least for value in self.bound):
            allowed = f"{len(self.units)} numbers above {least:g}"
            raise InvalidValueError(f"bound of action field {self.name!r}", self.bound, allowed)

    @property
    def size(self) -> int:
        """Number of components."""
        return len(self.units)

    @property
    def low(self) -> tuple[float, ...]:
        """What action -1 means, in the units."""
        return tuple(1.0 / value if self.factor else -value for value in self.bound)

    def value(self, action: Array) -> Array:
        """What components (..., size) in [-1, 1] mean, in the units."""
        bound = np.array(self.bound)
        if self.factor:
            return elementwise(math.pow, np.broadcast_to(bound, action.shape), action)
        meant: Array = bound * action
        return meant


Memory = Any
"""State of a mode between two periods: arrays with the environments along the first axis, or None."""


class ActionMode(Protocol):
    """Converts actions to joint torques, once in every period of the inner controller."""

    @property
    def fields(self) -> tuple[ActionField, ...]:
        """The fields of an action, in order."""

    def torque(
        self, action: Array, observation: Array, memory: Memory, starts: NDArray[np.bool_]
    ) -> tuple[Array, Memory]:
        """The torques of one inner period.

        Args:
            action: (N, size), within ±1; the same over an action's whole period.
            observation: (N, observation size), as a policy would see it now.
            memory: memory that the last call returned; None at first.
            starts: (N) whether an episode starts with this observation.

        Returns:
            (N, joints) torques normalised by the actuator limits, clipped later to ±1; and the memory.
        """


@dataclass(frozen=True, eq=False)
class ModeSetup:
    """The task and the interface for which an action mode is made.

    Attributes:
        task: `Task` whose observations the inner controller reads.
        torque_limit: actuator limits, by which joint torques are normalised (joints) [N m, N, N m].
        period: control period of the inner controller [s].
    """

    task: Any
    torque_limit: Array
    period: float


class ModeEntry(Protocol):
    """The code of an action mode, or of a family of them, one for each controller."""

    @property
    def controller(self) -> str:
        """Name of the inner controller; `ANY_CONTROLLER` for a family, empty for a mode without one."""

    def endings(self, layout: ObservationLayout | None) -> tuple[str, ...]:
        """Endings that follow the declared name in the names of the modes that an environment can have.

        Args:
            layout: layout of the environment's observations; None for the modes of all environments.

        Returns:
            an empty text for a single mode, `:<controller>` for each mode of a family; nothing where the
            environment does not observe what the controller reads.
        """

    def fields(self, torque_limit: Sequence[float], nominal: Sequence[float]) -> tuple[ActionField, ...]:
        """The fields of an action, in order.

        Args:
            torque_limit: actuator limits, by which joint torques are normalised (joints) [N m, N, N m].
            nominal: the robot's own limits (joints) [N m, N, N m].
        """

    def make(self, ending: str, setup: ModeSetup) -> ActionMode:
        """The mode.

        Args:
            ending: ending of the mode's name.
            setup: task and interface for which the mode is made.

        Raises:
            UnknownNameError: the mode names a command input that its controller does not have.
            MissingFieldError: the environment does not observe what the controller reads.
        """


@dataclass(frozen=True)
class ActionModeSpec:
    """The declaration of an action mode, or of a family of them.

    Attributes:
        name: name of the mode; for a family, the part of its modes' names before the colon.
        summary: what an action does, in one line for lists.
        entry: object that makes the mode.
        chapter: chapter of the report, which orders lists.
        revision: revision of the mode's behaviour, stored in results and agents' cards.
    """

    name: str
    summary: str
    entry: ModeEntry
    chapter: float = NOT_IN_THE_REPORT
    revision: int = 1

    @property
    def is_family(self) -> bool:
        """Whether it stands for a mode of each controller."""
        return self.entry.controller == ANY_CONTROLLER

    @property
    def label(self) -> str:
        """The name as lists show it, of a family with a placeholder."""
        return f"{self.name}:{ANY_CONTROLLER}" if self.is_family else self.name


ACTION_MODES: Registry[ActionModeSpec] = Registry("action_mode", "prp_gym.action_modes.modes")
"""The declared action modes beside `torque`; environments know of controllers through them alone."""


def register_action_mode(spec: ActionModeSpec) -> ActionModeSpec:
    """Declare an action mode, so that every environment that observes enough has it.

    Args:
        spec: declaration from this or another package.

    Returns:
        the same declaration.

    Raises:
        InvalidValueError: a name that another mode has, or that cannot be a file's name; a revision below 1.
    """
    if instance("action mode", spec, ActionModeSpec).name == TORQUE:
        raise InvalidValueError("name of action_mode", spec.name, "one that no other action_mode has")
    return ACTION_MODES.register(spec)


def list_action_modes(layout: ObservationLayout | None = None) -> list[str]:
    """Names of the action modes, or of those that an environment can have.

    Args:
        layout: `env.unwrapped.observation_layout`; None for all modes.
    """
    return [TORQUE, *_named(layout)]


def check_action_mode(name: object) -> None:
    """Refuse what is not the name of an action mode.

    Raises:
        UnknownNameError: no such mode.
    """
    if not isinstance(name, str) or name != TORQUE:
        choice("action_mode", name, list_action_modes())


def make_action_mode(name: str, setup: ModeSetup) -> ActionMode:
    """An action mode beside `torque`, for a task.

    Args:
        name: name of the mode, as `list_action_modes` gives it.
        setup: task and interface for which the mode is made.

    Raises:
        UnknownNameError: no such mode, or one that names a command input that its controller does not have.
        MissingFieldError: the environment does not observe what the controller reads.
    """
    modes = _named()
    spec, ending = modes[choice("action_mode", name, modes)]
    return spec.entry.make(ending, setup)


def _named(layout: ObservationLayout | None = None) -> dict[str, tuple[ActionModeSpec, str]]:
    """The declaration and the ending of every mode's name."""
    specs = ACTION_MODES.values()
    return {f"{spec.name}{end}": (spec, end) for spec in specs for end in spec.entry.endings(layout)}


def torque_field(torque_limit: Array) -> ActionField:
    """The only part of an action in mode `torque`.

    Args:
        torque_limit: joint torques at action 1 (joints) [N m, N, N m].
    """
    bound = tuple(torque_limit.tolist())
    return ActionField(TORQUE, TORQUE_UNITS[: len(bound)], "joint", bound, "joint torques τ")
