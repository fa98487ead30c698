"""A control law whose reference, gains or torques an action moves."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from prp_gym.baselines.policy import ControlInterface, PolicyState
from prp_gym.baselines.registry import make_law
from prp_gym.envs.action_mode import ActionField
from prp_gym.robot.arrays import Array
from prp_gym.tasks.fields import Field, ObservationLayout


class SteeredLaw:
    """A law that reads the action beside the observation, as more fields of it.

    Args:
        law: a baseline, with its `tuned` gains.
        fields: the parts of an action, which the law knows by their names.
        interface: what the law may know of the environment.

    Raises:
        MissingFieldError: the environment does not observe what the law reads.
    """

    def __init__(self, law: str, fields: tuple[ActionField, ...], interface: ControlInterface) -> None:
        self.fields = fields
        ends = np.cumsum([field.size for field in fields]).tolist()
        self._parts = [slice(end - field.size, end) for field, end in zip(fields, ends, strict=True)]
        more = [Field(f.name, f.units, f.frame, f.low, f.bound, f.description) for f in fields]
        layout = ObservationLayout((*interface.layout.fields, *more))
        self._law = make_law(law, replace(interface, layout=layout))

    def torque(
        self, action: Array, observation: Array, memory: PolicyState, starts: NDArray[np.bool_]
    ) -> tuple[Array, PolicyState]:
        """See `prp_gym.envs.action_mode.ActionMode`."""
        meant = [field.value(action[:, part]) for field, part in zip(self.fields, self._parts, strict=True)]
        seen = np.concatenate([observation, *meant], axis=1)
        torque, memory = self._law.predict(seen, memory, starts)
        return torque.astype(np.float64), memory


class ResidualMode:
    """A law to whose torques the action adds its own.

    Args:
        law: a baseline, with its `tuned` gains.
        field: the action, bounded by a share of the actuator limits.
        interface: what the law may know of the environment.

    Raises:
        MissingFieldError: the environment does not observe what the law reads.
    """

    def __init__(self, law: str, field: ActionField, interface: ControlInterface) -> None:
        self.fields = (field,)
        self._share = np.array(field.bound) / interface.torque_limit
        self._law = make_law(law, interface)

    def torque(
        self, action: Array, observation: Array, memory: PolicyState, starts: NDArray[np.bool_]
    ) -> tuple[Array, PolicyState]:
        """See `prp_gym.envs.action_mode.ActionMode`."""
        torque, memory = self._law.predict(observation, memory, starts)
        return torque + self._share * action, memory
