"""`ControlInterface`: what a controller may know of an environment besides its observations."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Self

import numpy as np

from prp_gym.errors import ErrorObservationError, InvalidValueError
from prp_gym.robot.arm import PRPArm
from prp_gym.robot.arrays import Array
from prp_gym.robot.link import Link, LinkParameters
from prp_gym.tasks.fields import ObservationLayout

Model = PRPArm | Link
"""A robot that a controller takes for the plant."""


@dataclass(frozen=True, eq=False)
class ControlInterface:
    """Everything that a controller may know of an environment besides its observations.

    Attributes:
        environment_id: id of the environment.
        layout: layout of the observation.
        torque_limit: joint torques at action 1 (joints) [N m, N, N m].
        period: control period [s].
        model: nominal robot, which may differ from the plant.
        target_impedance: target impedance of the task, by the names of settings: axes (6) of `inertia`,
            `damping` and `stiffness`; empty for a task that specifies none.
        greatest_stiffness: greatest stiffness of a surface that the task declares; infinite for a task that
            declares none [N/m].
    """

    environment_id: str
    layout: ObservationLayout
    torque_limit: Array
    period: float
    model: Model
    target_impedance: Mapping[str, Array] = field(default_factory=dict)
    greatest_stiffness: float = math.inf

    @classmethod
    def of(cls, env: Any) -> Self:
        """The interface of an environment of this suite or of many alike, wrapped or not.

        Raises:
            InvalidValueError: another environment, or one whose actions are not torques.
            ErrorObservationError: one that observes errors in place of quantities in their units.
        """
        inner = getattr(env, "unwrapped", env)
        try:
            task, mode = _attribute(inner, "task"), _attribute(inner, "action_mode")
            _require_fields(task, _attribute(inner, "observation_layout"), inner)
            if mode != "torque":
                raise InvalidValueError(
                    "action_mode", mode, "'torque': the actions of a controller are torques"
                )
            limit = np.asarray(_attribute(inner, "torque_limit"))
            return cls.of_task(task, limit, 1.0 / _attribute(inner, "control_frequency"))
        except AttributeError:
            raise InvalidValueError("env", env, "an environment of prp_gym, wrapped or not") from None

    @classmethod
    def of_task(cls, task: Any, torque_limit: Array, period: float) -> Self:
        """The interface of a task's environments.

        Args:
            task: `Task` of the environments.
            torque_limit: joint torques at action 1 (joints) [N m, N, N m].
            period: control period [s].
        """
        return cls(
            task.environment_id,
            task.layout,
            torque_limit,
            period,
            task.model,
            task.target_impedance,
            task.greatest_stiffness,
        )

    def model_with(self, parameters: Any) -> Model:
        """The same robot with other parameters, or the nominal one for None.

        Raises:
            InvalidValueError: parameters of another robot.
        """
        if parameters is None:
            return self.model
        if isinstance(parameters, LinkParameters) != isinstance(self.model, Link):
            expected = type(self.model.parameters).__name__
            raise InvalidValueError(
                f"model of {self.environment_id}", type(parameters).__name__, f"a {expected}"
            )
        return type(self.model)(parameters)


def _require_fields(task: Any, layout: ObservationLayout, env: Any) -> None:
    """Refuse an environment that observes something else than the fields of its task.

    Raises:
        ErrorObservationError: such an environment.
    """
    if layout != task.layout:
        raise ErrorObservationError(task.environment_id, _attribute(env, "control_frequency"))


def _attribute(env: Any, name: str) -> Any:
    """An attribute of an environment, or of the first one of many."""
    return getattr(env, name) if hasattr(env, name) else env.get_attr(name)[0]
