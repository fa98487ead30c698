"""What an action means: its declared parts, and who makes joint torques of it."""

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from prp_gym.errors import InvalidValueError
from prp_gym.robot.arrays import Array
from prp_gym.robot.parameters import TORQUE_UNITS

TORQUE = "torque"
"""The mode in which an action is the joint torques over their limits."""

INNER_FREQUENCY = 500.0
"""At which the law of every other mode runs [Hz], whatever the rate of actions."""


@dataclass(frozen=True)
class ActionField:
    """One named part of an action, whose components lie in [-1, 1].

    Attributes:
        name: of the part.
        units: one a component; their number is the field's size.
        frame: what it is resolved in.
        bound: what action 1 means, in the units; above 0, or above 1 for a factor.
        description: what it is.
        factor: whether an action a means bound^a, from 1/bound to bound, and not bound·a.
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
        meant: Array = bound**action if self.factor else bound * action
        return meant


Memory = Any
"""What a mode remembers between two periods: arrays with the environments along the first axis, or None."""


class ActionMode(Protocol):
    """Makes joint torques of actions, once in every period of the inner law."""

    @property
    def fields(self) -> tuple[ActionField, ...]:
        """The parts of an action, in order."""

    def torque(
        self, action: Array, observation: Array, memory: Memory, starts: NDArray[np.bool_]
    ) -> tuple[Array, Memory]:
        """The torques of one inner period.

        Args:
            action: (N, size), within ±1; the same over an action's whole period.
            observation: (N, observation size), as a policy would see it now.
            memory: what the last call returned; None at first.
            starts: (N) whether an episode starts with this observation.

        Returns:
            (N, joints) torques over their limits; what is beyond ±1 will be clipped; and the memory.
        """


class ModeMaker(Protocol):
    """Makes the action modes beside `torque`."""

    def __call__(self, name: str, task: Any, torque_limit: Array, period: float) -> ActionMode:
        """The mode of a name.

        Args:
            name: of the mode.
            task: a `Task`, whose observations the inner law will read.
            torque_limit: joint torques at 1 (joints) [N m, N, N m].
            period: of the inner law [s].

        Raises:
            UnknownNameError: no such mode.
            MissingFieldError: the task does not show what the inner law reads.
        """


def torque_field(torque_limit: Array) -> ActionField:
    """The only part of an action in mode `torque`.

    Args:
        torque_limit: joint torques at action 1 (joints) [N m, N, N m].
    """
    bound = tuple(torque_limit.tolist())
    return ActionField(TORQUE, TORQUE_UNITS[: len(bound)], "joint", bound, "joint torques τ")
