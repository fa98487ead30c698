"""`PeriodParts`: the parts whose formulas make up a control period."""

import copy
from collections.abc import Hashable
from typing import Any, NamedTuple, Self

import numpy as np

from prp_gym.envs.core.actuators import Actuators
from prp_gym.envs.core.sensors import Sensors
from prp_gym.envs.core.step_scoring import StepScoring
from prp_gym.errors import UntraceableError
from prp_gym.robot.arrays import Array
from prp_gym.symbolic.lifting import numbers_of, structure_of
from prp_gym.symbolic.state_arrays import StateRows
from prp_gym.tasks.parts import ErrorFunction, Reference, TaskParts
from prp_gym.tasks.trajectory import Trajectory


class PeriodParts(NamedTuple):
    """The parts of a control period, besides reference and physics.

    Attributes:
        errors: Error function of the task.
        actuators: Actuators.
        sensors: Sensors.
        scoring: Reward, costs and `info`.
        torque_limit: Joint torques at action 1 (joints) [N m, N, N m].
    """

    errors: ErrorFunction
    actuators: Actuators
    sensors: Sensors
    scoring: StepScoring
    torque_limit: Array

    @property
    def owners(self) -> tuple[ErrorFunction, Actuators]:
        """The parts that keep numbers from one period to the next."""
        return self.errors, self.actuators

    def formulas(self) -> Self:
        """Copies without random numbers and without what is kept, whose attributes may be replaced."""
        parts = type(self)(
            copy.copy(self.errors),
            self.actuators.without_noise(),
            self.sensors.without_noise(),
            self.scoring.with_fresh_reward(),
            self.torque_limit,
        )
        StateRows(self.owners).clear(parts.owners)
        return parts


class ReferenceRows:
    """What tells the reference of one environment from those of others, as rows of numbers.

    Args:
        reference: Reference in which every environment has begun an episode.

    Attributes:
        size: Number of columns.

    Raises:
        UntraceableError: a reference with other attributes than declared arrays.
    """

    def __init__(self, reference: Reference) -> None:
        known = {"_trajectory", *reference.state_arrays}
        for name, value in vars(reference).items():
            if isinstance(value, (np.ndarray, float, list, dict)) and name not in known:
                raise UntraceableError(
                    f"{type(reference).__name__}.{name} is not among its state_arrays and cannot be traced."
                )
        self._arrays = StateRows((reference,))
        self._shapes = {name: value.shape[1:] for name, value in vars(reference.trajectory).items()}
        self.size = self.read(reference).shape[1]
        self._formulas: Any = copy.copy(reference)
        self._formulas._trajectory = copy.copy(reference.trajectory)
        for name in self._shapes:
            object.__setattr__(self._formulas.trajectory, name, None)
        self._arrays.clear((self._formulas,))

    def kind(self, constants: tuple[type, ...]) -> Hashable:
        """What tells the formula from those of other references.

        Args:
            constants: Classes of objects whose numbers are constants.

        Raises:
            UntraceableError: a reference that holds something of which this cannot be told.
        """
        numbers = numbers_of(self._formulas, constants).tobytes()
        layout = tuple(self._shapes.items()), tuple(map(repr, self._arrays.arrays))
        return structure_of(self._formulas, constants), numbers, layout

    def read(self, reference: Reference) -> Array:
        """The rows (N, size) of the references."""
        values = [value.reshape(len(value), -1) for value in vars(reference.trajectory).values()]
        if self._arrays.size:
            values.append(self._arrays.read((reference,)))
        return np.concatenate(values, axis=1)

    def formula(self, row: Any) -> Reference:
        """A reference of one environment, of symbolic numbers (1, size)."""
        made = copy.copy(self._formulas)
        trajectory: Trajectory = copy.copy(made.trajectory)
        first = 0
        for name, shape in self._shapes.items():
            last = first + int(np.prod(shape, dtype=np.intp))
            object.__setattr__(trajectory, name, row[:, first:last].reshape((1, *shape)))
            first = last
        made._trajectory = trajectory
        self._arrays.write((made,), row[:, first:])
        reference: Reference = made
        return reference


class TaskConstants:
    """The attributes of a task's errors and reference that stay the same from episode to episode.

    Args:
        parts: Parts of the task.
    """

    def __init__(self, parts: TaskParts) -> None:
        self._known = [
            {
                name: (value, np.array(value)) if isinstance(value, np.ndarray) else (value, None)
                for name, value in _constants(part).items()
            }
            for part in (parts.errors, parts.reference)
        ]

    def check(self, parts: TaskParts) -> None:
        """Refuse parts of which another attribute has changed than their state arrays and the trajectory.

        Raises:
            UntraceableError: such a part.
        """
        owners: tuple[ErrorFunction | Reference, ...] = (parts.errors, parts.reference)
        for part, known in zip(owners, self._known, strict=True):
            present = _constants(part)
            if present.keys() != known.keys():
                raise UntraceableError(f"{type(part).__name__} has other attributes than before.")
            for name, value in present.items():
                before, copied = known[name]
                if value is not before or not (copied is None or np.array_equal(value, copied)):
                    raise UntraceableError(
                        f"{type(part).__name__} changes {name!r}, which is not among its state_arrays."
                    )


def _constants(part: ErrorFunction | Reference) -> dict[str, Any]:
    changing = {"_trajectory", *part.state_arrays}
    return {name: value for name, value in vars(part).items() if name not in changing}
