"""A control law whose reference, gains or torques an action moves."""

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from prp_gym.baselines.policy import ControlInterface
from prp_gym.baselines.registry import make_controller
from prp_gym.envs.action_mode import ActionField
from prp_gym.evaluation.policy_state import PolicyState
from prp_gym.robot.arrays import Array
from prp_gym.tasks.fields import Field, ObservationLayout

SteeredState = tuple[Array, PolicyState] | None
"""What the law reads of the action now (N, size), and the law's own state."""


class SteeredController:
    """A law that reads the action beside the observation, as more fields of it.

    What it reads follows the action with a delay of first order, from 0 at an episode's start: a stiff law
    would make a blow of every jump of its reference.

    Args:
        controller: a baseline, with its `tuned` gains.
        fields: the parts of an action, which the law knows by their names.
        interface: what the law may know of the environment.
        smoothing_time: time constant with which what the law reads follows the action [s].

    Raises:
        MissingFieldError: the environment does not observe what the law reads.
    """

    def __init__(
        self,
        controller: str,
        fields: tuple[ActionField, ...],
        interface: ControlInterface,
        smoothing_time: float,
    ) -> None:
        self.fields = fields
        self._progress = 1.0 - math.exp(-interface.period / smoothing_time)
        ends = np.cumsum([field.size for field in fields]).tolist()
        self._parts = [slice(end - field.size, end) for field, end in zip(fields, ends, strict=True)]
        more = [Field(f.name, f.units, f.frame, f.low, f.bound, f.description) for f in fields]
        layout = ObservationLayout((*interface.layout.fields, *more))
        self._controller = make_controller(controller, replace(interface, layout=layout))

    def torque(
        self, action: Array, observation: Array, memory: SteeredState, starts: NDArray[np.bool_]
    ) -> tuple[Array, SteeredState]:
        """See `prp_gym.envs.action_mode.ActionMode`."""
        before, state = memory or (np.zeros(action.shape), None)
        smooth = np.where(starts[:, None], 0.0, before)
        smooth += self._progress * (action - smooth)
        meant = [field.value(smooth[:, part]) for field, part in zip(self.fields, self._parts, strict=True)]
        seen = np.concatenate([observation, *meant], axis=1)
        torque, state = self._controller.predict(seen, state, starts)
        return torque.astype(np.float64), (smooth, state)


class ResidualMode:
    """A law to whose torques the action adds its own.

    Args:
        controller: a baseline, with its `tuned` gains.
        field: the action, bounded by a share of the actuator limits.
        interface: what the law may know of the environment.

    Raises:
        MissingFieldError: the environment does not observe what the law reads.
    """

    def __init__(self, controller: str, field: ActionField, interface: ControlInterface) -> None:
        self.fields = (field,)
        self._share = np.array(field.bound) / interface.torque_limit
        self._controller = make_controller(controller, interface)

    def torque(
        self, action: Array, observation: Array, memory: PolicyState, starts: NDArray[np.bool_]
    ) -> tuple[Array, PolicyState]:
        """See `prp_gym.envs.action_mode.ActionMode`."""
        torque, memory = self._controller.predict(observation, memory, starts)
        return torque + self._share * action, memory
