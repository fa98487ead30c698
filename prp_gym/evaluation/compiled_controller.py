"""`CompiledController`: the formulas of a controller as a compiled function."""

from typing import Any

import numpy as np

from prp_gym.evaluation.policy_state import LARGEST
from prp_gym.robot.arm import PRPArm
from prp_gym.robot.arrays import Array
from prp_gym.robot.link import Link
from prp_gym.symbolic.array import untraceable
from prp_gym.symbolic.compiled_method import CompiledMethod, of_arguments_alone
from prp_gym.tasks.fields import ObservationLayout

CONSTANTS = (PRPArm, Link, ObservationLayout)
"""Classes of objects whose numbers are constants of compiled code."""


class CompiledController(CompiledMethod):
    """A controller as a compiled function: observation, state, input and numbers -> action and state.

    Args:
        controller: controller with the methods `initial_state` and `act` of a baseline.
        observation: first observations (N, size).

    Attributes:
        initial_state: state at the start of an episode (N, size).

    Raises:
        UntraceableError: a controller that uses more than arithmetic on arrays, or keeps anything but its
            state.
        ShapeError: observations of another size.
        CompilerError: no compiler.
    """

    def __init__(self, controller: Any, observation: Array) -> None:
        layout = controller.interface.layout
        layout.checked(observation[0])
        state = controller.initial_state(layout.split(observation))
        if any(np.shape(part)[:1] != observation.shape[:1] for part in state):
            raise untraceable("a state without an axis of environments")
        self._shapes = [part.shape[1:] for part in state]
        self._kinds = [part.dtype for part in state]
        rows = [part.reshape(len(observation), -1).astype(np.float64) for part in state]
        self.initial_state = np.concatenate([np.zeros((len(observation), 0)), *rows], axis=1)
        shapes = {"observation": (1, layout.size), "state": (1, self.initial_state.shape[1]), "input": (1, 0)}
        kind = "act", tuple(self._shapes), tuple(map(str, self._kinds))
        super().__init__("prp_controller_act", self._act, controller, shapes, CONSTANTS, kind)

    def _act(self, controller: Any, observation: Any, state: Any, input: Any) -> dict[str, Any]:  # noqa: A002
        """The traced formula."""
        observed = {name: observation[..., part] for name, part in controller.interface.layout.slices.items()}
        parts, first = [], 0
        for shape, kind in zip(self._shapes, self._kinds, strict=True):
            last = first + int(np.prod(shape, dtype=np.intp))
            parts.append(state[:, first:last].reshape((1, *shape)).astype(kind))
            first = last

        def call() -> list[Any]:
            action, after = controller.act(observed, tuple(parts))
            return [action, *after]

        action, *after = of_arguments_alone(controller, call, observation)
        if action.shape != (1, *controller.interface.torque_limit.shape):
            raise untraceable(f"an action of shape {action.shape}")
        if [part.shape[1:] for part in after] != self._shapes:
            raise untraceable("a state whose shape changes")
        return _refused(action, after) if after else {"action": action, "after": state}


def _refused(action: Any, after: Any) -> dict[str, Any]:
    """Action and state in a row, with an action that is no number where `predict` would refuse the state."""
    kept = np.concatenate([part.astype(np.float64).reshape((1, -1)) for part in after], axis=1)
    allowed = (np.abs(kept) <= LARGEST).all(axis=1, keepdims=True)
    return {"action": np.where(allowed, action.astype(np.float64), np.nan), "after": kept}
