"""`InnerControllerSource`: the controller inside an action mode, with actions of zero."""

from collections.abc import Mapping
from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from prp_gym.evaluation.rollout import Policy
from prp_gym.viewing.policy_source import PolicySource


class ZeroActions:
    """A policy whose actions are zero, which leave the controller inside an action mode as it is.

    Args:
        size: number of components of an action.
    """

    def __init__(self, size: int) -> None:
        self._size = size

    def predict(
        self,
        observation: NDArray[Any],
        state: Any = None,
        episode_start: NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[NDArray[np.float32], Any]:
        """An action of zero, and the state as it is."""
        return np.zeros(self._size, dtype=np.float32), state


class InnerControllerSource(PolicySource):
    """The controller inside an action mode, which no action changes.

    Args:
        environment_id: id of the environment.
        action_mode: name of the action mode; in the mode `torque` the joint torques are zero.
        control_frequency: control frequency [Hz].
    """

    def __init__(self, environment_id: str, action_mode: str, control_frequency: float) -> None:
        self._keywords: dict[str, Any] = {"action_mode": action_mode, "control_frequency": control_frequency}
        self._environment_id = environment_id
        self.name = f"zero actions in mode {action_mode}"

    def make_env(self, scenario: str) -> gymnasium.Env[Any, Any]:
        """See `PolicySource.make_env`."""
        made: gymnasium.Env[Any, Any] = gymnasium.make(
            self._environment_id, scenario=scenario, **self._keywords
        )
        return made

    def make_policy(self, env: gymnasium.Env[Any, Any], factors: Mapping[str, float]) -> Policy:
        """See `PolicySource.make_policy`."""
        return ZeroActions(int(np.prod(env.action_space.shape or ())))
