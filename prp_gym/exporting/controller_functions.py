"""`ControllerFunctions`: a controller as two functions of numbers, its gains folded into them."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from prp_gym.baselines import Baseline
from prp_gym.errors import UntraceableError
from prp_gym.evaluation.compiled_controller import CONSTANTS, ControllerFormula
from prp_gym.symbolic.derivatives import unrounded
from prp_gym.symbolic.function import SymbolicFunction
from prp_gym.symbolic.lifting import Formula, numbers_of, trace_method
from prp_gym.symbolic.rewriting import with_constants

OBSERVATION, STATE, TORQUE, NEXT_STATE = "observation", "state", "torque", "next_state"
"""Names of the arguments and results."""


@dataclass(frozen=True)
class ControllerFunctions:
    """A controller as functions in double precision, without the rounding of actions to single precision.

    Attributes:
        begin: `observation` (size) -> `next_state` (1, states), the state at the start of an episode.
        step: `observation` (size) and `state` (1, states) -> `torque` (1, joints), limited [N m, N, N m], and
            `next_state` (1, states).
        state_size: number of states.
    """

    begin: SymbolicFunction
    step: SymbolicFunction
    state_size: int

    @classmethod
    def of(cls, controller: Baseline[Any]) -> Self:
        """The functions of a controller.

        Args:
            controller: controller with its gains, for an environment.

        Raises:
            UntraceableError: a controller whose `predict` is its own, that uses more than arithmetic on
                arrays, or that keeps anything but its state.
            DataDependentBranchError: one that branches on observations or states.
        """
        require_traceable(controller)
        size = controller.interface.layout.size
        with np.errstate(all="ignore"):  # only the shapes of this state matter
            formula = ControllerFormula(controller, np.zeros((1, size)))
        state_size = formula.initial_state.shape[1]

        def begin(own: Any, observation: Any, state: Any) -> dict[str, Any]:
            return {NEXT_STATE: formula.begin(own, observation)}

        def step(own: Any, observation: Any, state: Any) -> dict[str, Any]:
            action, after = formula(own, observation, state)
            torque = action.astype(np.float64) * own.interface.torque_limit
            return {TORQUE: torque, NEXT_STATE: formula.row(after, 1)}

        shapes = {OBSERVATION: (1, size), STATE: (1, state_size)}
        return cls(
            _folded(controller, "begin", begin, shapes),
            _folded(controller, "step", step, shapes),
            state_size,
        )


def require_traceable(controller: Any) -> None:
    """Refuse what does not act by the method `act` of a `Baseline`.

    Raises:
        UntraceableError: such a policy.
    """
    kind = type(controller)
    if not isinstance(controller, Baseline):
        raise UntraceableError(
            f"{kind.__name__} has a method `predict` of its own, of which no formula is known; only a "
            "controller that derives from `Baseline`, or a function with @prp_gym.controller, can be traced."
        )
    if not kind.compiled or "predict" in vars(controller):
        raise UntraceableError(
            f"{kind.__name__} replaces `Baseline.predict`, so that its actions are not those of its `act` "
            "and cannot be traced."
        )


def _folded(
    controller: Baseline[Any], name: str, formula: Formula, shapes: Mapping[str, tuple[int, ...]]
) -> SymbolicFunction:
    """A formula of a controller, with its numbers as constants and without rounding."""
    traced = trace_method(name, formula, controller, shapes, CONSTANTS).function
    return with_constants(unrounded(traced, name), name, numbers=numbers_of(controller, CONSTANTS))
