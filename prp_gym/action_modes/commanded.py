"""A controller whose reference, gains or rates an action drives through the controller's command inputs."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from prp_gym.baselines.base.control_interface import ControlInterface
from prp_gym.baselines.base.make import make_controller
from prp_gym.baselines.base.spec import CONTROLLERS
from prp_gym.envs.action_mode import ActionField, ActionMode, ModeSetup
from prp_gym.errors import UnknownNameError
from prp_gym.evaluation.policy_state import PolicyState
from prp_gym.robot.arrays import Array
from prp_gym.tasks.fields import Field, ObservationLayout

SMOOTHING_TIME = 0.1
"""Time constant with which the command inputs of a controller follow the action [s]."""

CommandedState = tuple[Array, PolicyState] | None
"""The smoothed action (N, size), and the controller's own state."""


@dataclass(frozen=True)
class CommandInputs:
    """An action mode that drives command inputs of a controller.

    Attributes:
        controller: name of the inner controller, which has its `tuned` gains.
        inputs: fields of an action, by the names of the controller's command inputs; fields in joint space
            have as many components as the robot has joints.
    """

    controller: str
    inputs: tuple[ActionField, ...]

    def endings(self, layout: ObservationLayout | None) -> tuple[str, ...]:
        """See `prp_gym.envs.action_mode.ModeEntry`."""
        runs = layout is None or not CONTROLLERS.find(self.controller).missing_fields(layout)
        return ("",) if runs else ()

    def fields(self, torque_limit: Sequence[float], nominal: Sequence[float]) -> tuple[ActionField, ...]:
        """See `prp_gym.envs.action_mode.ModeEntry`; the limits have no effect."""
        count = len(torque_limit)
        return tuple(
            replace(field, units=field.units[:count], bound=field.bound[:count])
            if field.frame == "joint"
            else field
            for field in self.inputs
        )

    def make(self, ending: str, setup: ModeSetup) -> ActionMode:
        """See `prp_gym.envs.action_mode.ModeEntry`."""
        interface = ControlInterface.of_task(setup.task, setup.torque_limit, setup.period)
        fields = self.fields(setup.torque_limit.tolist(), setup.task.model.parameters.torque_limit)
        return CommandedController(self.controller, fields, interface, SMOOTHING_TIME)


class CommandedController:
    """A controller that reads the action as additional fields of the observation.

    The command inputs follow the action through a first-order low-pass filter, from 0 at the start of an
    episode, since a stiff controller would turn every jump of its reference into an impact.

    Args:
        controller: name of the controller, which has its `tuned` gains.
        fields: fields of an action, by the names of the controller's command inputs.
        interface: what the controller may know of the environment.
        smoothing_time: time constant with which the command inputs follow the action [s].

    Raises:
        UnknownNameError: a field that is no command input of the controller.
        MissingFieldError: the environment does not observe what the controller reads.
    """

    def __init__(
        self,
        controller: str,
        fields: tuple[ActionField, ...],
        interface: ControlInterface,
        smoothing_time: float,
    ) -> None:
        valid = CONTROLLERS.find(controller).command_inputs
        for field in fields:
            if field.name not in valid:
                raise UnknownNameError(f"command input of controller {controller!r}", field.name, valid)
        self.fields = fields
        self._progress = 1.0 - math.exp(-interface.period / smoothing_time)
        ends = np.cumsum([field.size for field in fields]).tolist()
        self._parts = [slice(end - field.size, end) for field, end in zip(fields, ends, strict=True)]
        more = [Field(f.name, f.units, f.frame, f.low, f.bound, f.description) for f in fields]
        layout = ObservationLayout((*interface.layout.fields, *more))
        self._controller = make_controller(controller, replace(interface, layout=layout))

    def torque(
        self, action: Array, observation: Array, memory: CommandedState, starts: NDArray[np.bool_]
    ) -> tuple[Array, CommandedState]:
        """See `prp_gym.envs.action_mode.ActionMode`."""
        before, state = memory or (np.zeros(action.shape), None)
        smooth = np.where(starts[:, None], 0.0, before)
        smooth += self._progress * (action - smooth)
        meant = [field.value(smooth[:, part]) for field, part in zip(self.fields, self._parts, strict=True)]
        seen = np.concatenate([observation, *meant], axis=1)
        torque, state = self._controller.predict(seen, state, starts)
        return torque.astype(np.float64), (smooth, state)
