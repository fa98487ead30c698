"""Controllers to whose torques an action adds its own: one action mode for each of them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from prp_gym.baselines.base.control_interface import ControlInterface
from prp_gym.baselines.base.make import list_baselines, make_controller
from prp_gym.envs.action_mode import ANY_CONTROLLER, ActionField, ActionMode, ModeSetup
from prp_gym.evaluation.policy_state import PolicyState
from prp_gym.robot.arrays import Array
from prp_gym.robot.parameters import TORQUE_UNITS
from prp_gym.tasks.fields import ObservationLayout

RESIDUAL_SHARE = 0.2
"""Share of the actuator limits, at most of the robot's own, that a residual may add to the torques."""


@dataclass(frozen=True)
class ResidualTorque:
    """A family of action modes that add to the torques of a controller.

    Attributes:
        share: largest added torque, as a share of the actuator limits but at most of the robot's own [1].
    """

    share: float = RESIDUAL_SHARE

    @property
    def controller(self) -> str:
        """Any controller: every one has a mode."""
        return ANY_CONTROLLER

    def endings(self, layout: ObservationLayout | None) -> tuple[str, ...]:
        """See `prp_gym.envs.action_mode.ModeEntry`."""
        return tuple(f":{controller}" for controller in list_baselines(layout))

    def fields(self, torque_limit: Sequence[float], nominal: Sequence[float]) -> tuple[ActionField, ...]:
        """See `prp_gym.envs.action_mode.ModeEntry`.

        Where an environment's actuator limits exceed the robot's own or are infinite, the share refers to the
        robot's own limits.
        """
        bound = tuple(self.share * min(limits) for limits in zip(torque_limit, nominal, strict=True))
        units = TORQUE_UNITS[: len(bound)]
        description = "added to the torques of the controller"
        return (ActionField("residual_torque", units, "joint", bound, description),)

    def make(self, ending: str, setup: ModeSetup) -> ActionMode:
        """See `prp_gym.envs.action_mode.ModeEntry`."""
        interface = ControlInterface.of_task(setup.task, setup.torque_limit, setup.period)
        (field,) = self.fields(setup.torque_limit.tolist(), setup.task.model.parameters.torque_limit)
        return ResidualController(ending.removeprefix(":"), field, interface)


class ResidualController:
    """A controller to whose torques the action adds its own.

    Args:
        controller: name of the controller, which has its `tuned` gains.
        field: field of the action, bounded by a share of the actuator limits.
        interface: what the controller may know of the environment.

    Raises:
        MissingFieldError: the environment does not observe what the controller reads.
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
        return torque.astype(np.float64) + self._share * action, memory
