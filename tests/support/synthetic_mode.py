"""A mode of actions that shows what a loop asks of one, and diverges in the period that an action names."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from prp_gym.envs.action_mode import ActionField
from prp_gym.robot.arrays import Array

MAKER = "tests.support.synthetic_mode:make"
WILD: dict[str, Any] = {"action_mode": "late", "action_modes": MAKER, "torque_limit": None}
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
        when = np.round(self.fields[0].value(action[:, :1]))[:, 0]
        torque = np.where(count == when, 0.01, self.fields[1].value(action[:, 1]) * np.sin(count))
        return np.tile(torque[:, None], self.joints), np.stack([count, observation[:, 0]], axis=1)


def make(name: str, task: Any, torque_limit: Array, period: float) -> LateMode:
    """See `prp_gym.envs.action_mode.ModeMaker`."""
    assert name == "late"
    assert period == 0.002
    return LateMode(len(torque_limit))


def violent_in(period: float) -> float:
    """The action that means a period."""
    return period / 100.0
