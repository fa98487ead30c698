"""`ControllerJacobian`: from observations to the applied torques, and exact derivatives of it."""

import ctypes
from collections.abc import Mapping
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from prp_gym.envs.core.actuators import Actuators
from prp_gym.envs.core.argument_checks import limit_actions
from prp_gym.envs.core.period_parts import PeriodParts
from prp_gym.evaluation.compiled_controller import CONSTANTS, ControllerFormula
from prp_gym.evaluation.policy_state import PolicyState, state_to_begin_with
from prp_gym.robot.arrays import Array
from prp_gym.symbolic.c_source import PREAMBLE, c_function
from prp_gym.symbolic.compiler import load_library
from prp_gym.symbolic.derivatives import transposed
from prp_gym.symbolic.function import SymbolicFunction
from prp_gym.symbolic.lifting import numbers_of, trace_method
from prp_gym.symbolic.state_arrays import StateRows

_NAME = "prp_controlled"
_INPUTS = ("observation", "memory", "state")
_OUTPUTS = ("torque", "kept", "after")

_ROWS = """
void prp_controlled_rows(
    const double *observation, const double *memory, const double *state, const double *numbers, double *rows)
{
    for (int i = 0; i < PRP_RESULTS; i++) {
        double unit[PRP_RESULTS] = {0.0}, *row = rows + PRP_ARGUMENTS * i;
        unit[i] = 1.0;
        prp_controlled_transposed(
            observation, memory, state, numbers, unit, unit + PRP_TORQUES, unit + PRP_TORQUES + PRP_MEMORY,
            row, row + PRP_OBSERVED, row + PRP_OBSERVED + PRP_MEMORY);
    }
}
"""


class Derivatives(NamedTuple):
    """What a controller and the actuators do in a period, around one observation.

    Attributes:
        results: applied torques (n), what the actuators keep, state of the controller.
        by_observation: derivatives (results, observation size).
        by_memory: derivatives (results, what the actuators keep).
        by_state: derivatives (results, state size).
    """

    results: Array
    by_observation: Array
    by_memory: Array
    by_state: Array


class ControllerJacobian:
    """A controller and the actuators of one environment.

    The noise of the actuators is its mean, zero. The rounding of actions to single precision is left out of
    the derivatives, as it would make them zero.

    Args:
        controller: controller with the methods `initial_state` and `act` of a baseline.
        parts: parts of a control period, with what the actuators keep at present.
        observation: present observation (size).

    Attributes:
        reads: mask (size) of the components of the observation on which anything depends.
        memory: what the actuators keep (any size).
        delayed: columns of the memory on which anything depends: commands that are yet to be applied.

    Raises:
        UntraceableError: a controller that uses more than arithmetic on arrays, or keeps anything but its
            state.
        ShapeError: an observation of another size.
        CompilerError: no compiler.
    """

    def __init__(self, controller: Any, parts: PeriodParts, observation: Array) -> None:
        self._controller, self._observation = controller, observation
        self._formula = ControllerFormula(controller, observation[None])
        self._rows = StateRows((parts.actuators,))
        self.memory = self._rows.read((parts.actuators,))[0]
        formulas = parts.actuators.without_noise()
        self._rows.clear((formulas,))
        target = controller, formulas, parts.torque_limit
        self._numbers = numbers_of(target, CONSTANTS)
        shapes = {
            "observation": (1, len(observation)),
            "memory": (1, self._rows.size),
            "state": self._formula.initial_state.shape,
        }
        kind = "controlled", self._formula.kind, tuple(map(repr, self._rows.arrays))
        self._function = trace_method(_NAME, self._controlled, target, shapes, CONSTANTS, kind).function
        self._library = load_library(_source(self._function))
        used = _used_inputs(self._function)
        self.reads, memory = (
            np.array([f"{name}[{index}]" in used for index in range(size)], dtype=np.bool_)
            for name, size in (("observation", len(observation)), ("memory", self._rows.size))
        )
        self.delayed = np.flatnonzero(memory)

    def _controlled(
        self, target: tuple[Any, Actuators, Any], observation: Any, memory: Any, state: Any
    ) -> Mapping[str, Any]:
        """The traced formula."""
        controller, actuators, limit = target
        action, after = self._formula(controller, observation, state)
        self._rows.write((actuators,), memory)
        within, _ = limit_actions(action.astype(np.float64), np.ones(action.shape))
        torque = actuators.transmit(within * limit, np.zeros(action.shape))
        kept = self._rows.read((actuators,)) if self._rows.size else memory
        later = [part.astype(np.float64).reshape((1, -1)) for part in after]
        return {"torque": torque, "kept": kept, "after": np.concatenate([state[:, :0], *later], axis=1)}

    def state_row(self, state: PolicyState) -> Array:
        """The state of the controller as a row (size): that which `predict` returned, or a new one for None.

        Raises:
            ShapeError: a state of another controller, or of several environments.
            InvalidValueError: a state that is not a tuple of arrays of numbers, or holds huge ones.
            NonFiniteError: NaN or infinity in the state.
        """
        layout = self._controller.interface.layout
        fresh = self._controller.initial_state(layout.split(self._observation))
        given = state_to_begin_with(fresh, state, None, ())
        row: Array = self._formula.row(tuple(part[None] for part in given), 1)[0]
        return row

    def at(self, state: Array) -> Derivatives:
        """The derivatives around a state of the controller (size)."""
        sizes = [self._function.inputs[name].size for name in _INPUTS]
        results = {name: np.empty(self._function.outputs[name].size) for name in _OUTPUTS}
        rows = np.empty((sum(map(len, results.values())), sum(sizes)))
        given = (self._observation, self.memory, state, self._numbers)
        self._call(_NAME, *given, *results.values())
        self._call(f"{_NAME}_rows", *given, rows)
        by_observation, by_memory, by_state = np.split(rows, np.cumsum(sizes)[:-1], axis=1)
        return Derivatives(np.concatenate(list(results.values())), by_observation, by_memory, by_state)

    def _call(self, name: str, *arrays: Array) -> None:
        """Call a compiled function with arrays."""
        kept = [np.ascontiguousarray(array) for array in arrays]
        function: Any = getattr(self._library, name)
        function.restype = None
        function(*(ctypes.c_void_p(array.ctypes.data) for array in kept))


@lru_cache(maxsize=256)
def _source(function: SymbolicFunction) -> str:
    """The C source of a function and of its derivatives."""
    sizes = {
        "TORQUES": function.outputs["torque"].size,
        "MEMORY": function.outputs["kept"].size,
        "RESULTS": sum(function.outputs[name].size for name in _OUTPUTS),
        "OBSERVED": function.inputs["observation"].size,
        "ARGUMENTS": sum(function.inputs[name].size for name in _INPUTS),
    }
    defined = "".join(f"#define PRP_{name} {size}\n" for name, size in sizes.items())
    reverse = transposed(function, f"{_NAME}_transposed", _INPUTS)
    return "\n".join([PREAMBLE, defined, c_function(function, ""), c_function(reverse), _ROWS])


@lru_cache(maxsize=256)
def _used_inputs(function: SymbolicFunction) -> frozenset[str]:
    """Names of the inputs on which a function depends."""
    return frozenset(node.name for node in function.nodes() if node.is_input)
