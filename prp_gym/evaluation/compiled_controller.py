"""`CompiledController`: the formulas of a controller as a compiled function."""

import ctypes
from collections.abc import Sequence
from typing import Any, NamedTuple, Self

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


class ControllerFormula:
    """The formula of a controller's `act`, with its state in a row of numbers.

    Args:
        controller: controller with the methods `initial_state` and `act` of a baseline.
        observation: observations (N, size) at the start of episodes.

    Attributes:
        initial_state: state at the start of an episode (N, size).
        kind: what tells the formula from those of controllers with another state.

    Raises:
        ShapeError: observations of another size.
        UntraceableError: a state without an axis of environments.
    """

    def __init__(self, controller: Any, observation: Array) -> None:
        layout = controller.interface.layout
        layout.checked(observation[0])
        state = controller.initial_state(layout.split(observation))
        if any(np.shape(part)[:1] != observation.shape[:1] for part in state):
            raise untraceable("a state without an axis of environments")
        self._shapes = [part.shape[1:] for part in state]
        self._kinds = [part.dtype for part in state]
        self.initial_state = self.row(state, len(observation))
        self.kind = "act", tuple(self._shapes), tuple(map(str, self._kinds))

    def row(self, state: tuple[Array, ...], count: int) -> Array:
        """A state of `count` environments as rows of numbers (count, size)."""
        rows = [part.reshape(count, -1).astype(np.float64) for part in state]
        return np.concatenate([np.zeros((count, 0)), *rows], axis=1)

    def begin(self, controller: Any, observation: Any) -> Any:
        """State at the start of an episode in a row (1, size), of symbolic arrays.

        Args:
            controller: copy of the controller, whose numbers are symbolic.
            observation: first observation (1, size).

        Raises:
            UntraceableError: a controller that keeps something outside of its state.
        """
        observed = _split(controller, observation)
        state = of_arguments_alone(controller, lambda: controller.initial_state(observed), observation)
        return self.row(tuple(state), 1)

    def __call__(self, controller: Any, observation: Any, state: Any) -> tuple[Any, tuple[Any, ...]]:
        """Action and state a period later, of symbolic arrays.

        Args:
            controller: copy of the controller, whose numbers are symbolic.
            observation: (1, size).
            state: state in a row (1, size).

        Raises:
            UntraceableError: a controller that keeps something outside of its state, or returns an action or
                a state of another shape.
        """
        observed, parts, first = _split(controller, observation), [], 0
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
        return action, tuple(after)


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
        formula = ControllerFormula(controller, observation)
        self.initial_state = formula.initial_state

        def act(own: Any, observation: Any, state: Any, input: Any) -> dict[str, Any]:  # noqa: A002
            action, after = formula(own, observation, state)
            return _refused(action, after) if after else {"action": action, "after": state}

        size, columns = controller.interface.layout.size, self.initial_state.shape[1]
        shapes = {"observation": (1, size), "state": (1, columns), "input": (1, 0)}
        super().__init__("prp_controller_act", act, controller, shapes, CONSTANTS, formula.kind)


class CompiledControllers(NamedTuple):
    """Controllers of one compiled function, each with its gains, in the rows of N environments.

    Attributes:
        function: address of the compiled function.
        numbers: numbers of the controller of each environment (N, P).
        initial_state: states at the start of the episodes (N, size).
    """

    function: ctypes.c_void_p
    numbers: Array
    initial_state: Array

    @classmethod
    def of(cls, controllers: Sequence[CompiledController]) -> Self:
        """Controllers one after the other, each in as many environments as it has observed.

        Args:
            controllers: controllers with the same `function`, at least one.
        """
        rows = [np.tile(own.numbers, (len(own.initial_state), 1)) for own in controllers]
        states = [own.initial_state for own in controllers]
        return cls(controllers[0].function, np.concatenate(rows), np.concatenate(states))


def _refused(action: Any, after: Any) -> dict[str, Any]:
    """Action and state in a row, with an action that is no number where `predict` would refuse the state."""
    kept = np.concatenate([part.astype(np.float64).reshape((1, -1)) for part in after], axis=1)
    allowed = (np.abs(kept) <= LARGEST).all(axis=1, keepdims=True)
    return {"action": np.where(allowed, action.astype(np.float64), np.nan), "after": kept}


def _split(controller: Any, observation: Any) -> dict[str, Any]:
    """The fields of a symbolic observation (1, size) by name."""
    return {name: observation[..., part] for name, part in controller.interface.layout.slices.items()}
