"""A mode of actions that shows what a loop asks of one, and diverges in the period that an action names."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from prp_gym.envs.action_mode import ActionField, ActionMode, ActionModeSpec, ModeSetup
from prp_gym.robot.arrays import Array
from prp_gym.tasks.fields import ObservationLayout

WILD: dict[str, Any] = {"action_mode": "late", "torque_limit": None}
GENTLE = 1e-6  # of the limit that stands for none: 1 N m
NEVER = 0.0


@dataclass(frozen=True)
class LateMode:
    """Gentle torques, but of 10⁴ N m in the period of an episode that an action names: too fast for a while.

    Its memory, (N, 2), counts the periods of an episode and holds the last observation's first number.
    """

    joints: int
    fields = (
        ActionField("period", ("1",), "none", (100.0,), "in which to be violent; 0 for never"),
        ActionField("pull", ("1",), "joint", (GENTLE,), "torque of every joint"),
    )

    def torque(
        self, action: Array, observation: Array, memory: Any, starts: NDArray[np.bool_]
    ) -> tuple[Array, Any]:
        """See `prp_gym.envs.action_mode.ActionMode`."""
        before = np.zeros((len(action), 2)) if memory is None else memory
        count = np.where(starts, 0.0, before[:, 0]) + 1.0
        when = np.rint(self.fields[0].value(action[:, :1]))[:, 0]
        torque = np.where(count == when, 0.01, self.fields[1].value(action[:, 1]) * np.sin(count))
        every: Array = np.broadcast_to(torque[:, None], (len(torque), self.joints))
        return every, np.stack([count, observation[:, 0]], axis=1)


@dataclass(frozen=True)
class LateEntry:
    """Makes the mode for any environment; it runs no controller.

    Attributes:
        kind: class of the mode, which takes the number of joints.
    """

    kind: Callable[[int], ActionMode] = LateMode
    controller = ""

    def endings(self, layout: ObservationLayout | None) -> tuple[str, ...]:
        """See `prp_gym.envs.action_mode.ModeEntry`."""
        return ("",)

    def fields(self, torque_limit: Sequence[float], nominal: Sequence[float]) -> tuple[ActionField, ...]:
        """See `prp_gym.envs.action_mode.ModeEntry`."""
        return LateMode.fields

    def make(self, ending: str, setup: ModeSetup) -> ActionMode:
        """See `prp_gym.envs.action_mode.ModeEntry`."""
        assert (ending, setup.period) == ("", 0.002)
        return self.kind(len(setup.torque_limit))


LATE = ActionModeSpec("late", "torques that may become violent", LateEntry())


def violent_in(period: float) -> float:
    """The action that means a period."""
    return period / 100.0
