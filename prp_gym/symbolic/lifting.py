"""Functions traced from methods of objects, with the numbers that the objects hold as inputs.

A controller holds gains, a task scales and bounds. Where these are inputs and no constants, one compiled
function serves every controller and every task of a kind, and it has derivatives by its gains.
"""

import copy
import pickle
from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass
from types import FunctionType, MethodType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from prp_gym.errors import DataDependentBranchError
from prp_gym.symbolic.array import SymbolicArray
from prp_gym.symbolic.function import SymbolicFunction, Symbols
from prp_gym.symbolic.graph import Graph, Node, reached

Formula = Callable[..., Mapping[str, Any]]
_NUMBERS = "numbers"
_PLAIN = (bool, int, str, bytes, slice, range, type, type(None))


class _Walk:
    """A copy of objects in which every real number is replaced.

    Numbers are floats and arrays of them, wherever attributes, tuples, lists and dictionaries lead; objects
    of the classes `constants` stay as they are, as does everything else.

    Args:
        replace: function of a number or an array of them, in the order in which they are found.
        constants: classes of objects whose numbers are constants.
    """

    def __init__(self, replace: Callable[[Any], Any], constants: tuple[type, ...]) -> None:
        self._replace, self._constants = replace, constants
        self._known: dict[int, Any] = {}
        self._kept: list[object] = []  # so that no address is used twice
        self.structure: list[Hashable] = []

    def copied(self, value: Any) -> Any:
        """The copy of a value."""
        if isinstance(value, (float, np.floating)):
            self.structure.append("number")
            return self._replace(float(value))
        if isinstance(value, np.ndarray) and value.dtype == np.float64:
            self.structure.append(("numbers", value.shape))
            return self._replace(value)
        if isinstance(value, np.ndarray):
            self.structure.append((str(value.dtype), value.shape, value.tobytes()))
            return value
        if isinstance(value, _PLAIN) or isinstance(value, self._constants):
            self.structure.append(_constant(value))
            return value
        if id(value) in self._known:
            self.structure.append(("again", list(self._known).index(id(value))))
            return self._known[id(value)]
        self._kept.append(value)
        return self._of_parts(value)

    def _of_parts(self, value: Any) -> Any:
        """The copy of a container or an object, part by part."""
        self.structure.append((type(value), len(value) if isinstance(value, (tuple, list, dict)) else -1))
        if isinstance(value, (tuple, list)):
            parts = [self.copied(part) for part in value]
            made = type(value)(*parts) if hasattr(value, "_fields") else type(value)(parts)
            self._known[id(value)] = made
            return made
        if isinstance(value, dict):
            self._known[id(value)] = made = {}
            for key, part in value.items():
                self.structure.append(key)
                made[key] = self.copied(part)
            return made
        if isinstance(value, MethodType):
            self._known[id(value)] = bound = MethodType(value.__func__, self.copied(value.__self__))
            return bound
        if not hasattr(value, "__dict__") or isinstance(value, FunctionType):
            self.structure.append(id(value))
            return value
        self._known[id(value)] = made = copy.copy(value)
        for name, part in vars(value).items():
            self.structure.append(name)
            object.__setattr__(made, name, self.copied(part))
        return made


def _constant(value: Any) -> Hashable:
    """What tells a constant from others of its class."""
    return value if isinstance(value, type) else (type(value), pickle.dumps(value))


def numbers_of(target: Any, constants: tuple[type, ...] = ()) -> NDArray[np.float64]:
    """The numbers that objects hold (P), in the order of the inputs of `trace_method`.

    Args:
        target: objects, in tuples and the like.
        constants: classes of objects whose numbers are constants.
    """
    found: list[NDArray[np.float64]] = []

    def keep(value: Any) -> Any:
        found.append(np.ravel(value))
        return value

    _Walk(keep, constants).copied(target)
    return np.concatenate([np.zeros(0), *found])


def structure_of(target: Any, constants: tuple[type, ...] = ()) -> tuple[Hashable, ...]:
    """What objects are apart from their numbers; valid as long as they live."""
    walk = _Walk(lambda value: value, constants)
    walk.copied(target)
    return tuple(walk.structure)


@dataclass(frozen=True, eq=False)
class LiftedFunction:
    """A function traced from methods of objects, with their numbers as the input `numbers` (P).

    Attributes:
        function: the function.
        fixed: numbers on which the formula branches, with the values for which it was traced, by their
            positions; of them the function does not depend.
    """

    function: SymbolicFunction
    fixed: Mapping[int, float]

    def serves(self, numbers: NDArray[np.float64]) -> bool:
        """Whether the function is that of other objects of the same structure, with these numbers (P)."""
        return all(numbers[position] == value for position, value in self.fixed.items())


def trace_method(
    name: str,
    formula: Formula,
    target: Any,
    shapes: Mapping[str, tuple[int, ...]],
    constants: tuple[type, ...] = (),
    kind: Hashable = None,
) -> LiftedFunction:
    """Trace a formula of objects; once for all objects of one structure, if the formula has a kind.

    Args:
        name: name of the function.
        formula: takes a copy of the objects, whose numbers are symbolic and whose attributes it may change,
            and symbolic arrays by the names of `shapes`; returns its results by name.
        target: objects, in tuples and the like.
        shapes: shapes of the arguments.
        constants: classes of objects whose numbers are constants.
        kind: what tells the formula from others, apart from objects, name and shapes; None to trace anew.

    Returns:
        the function of the arguments and of `numbers`. A number on which the formula branches is a constant.

    Raises:
        UntraceableError: a formula that uses more than arithmetic on arrays.
        DataDependentBranchError: one that branches on its arguments.
    """
    values = numbers_of(target, constants)
    if kind is None:
        return _trace_with(values, name, formula, target, shapes, constants)
    key = name, kind, tuple(shapes.items()), structure_of(target, constants)
    known = _KNOWN.pop(key, None) or _Known(target, [])
    _KNOWN[key] = known  # the latest last
    for function in known.functions:
        if function.serves(values):
            return function
    known.functions.append(_trace_with(values, name, formula, target, shapes, constants))
    while len(_KNOWN) > _MOST_KNOWN:
        _KNOWN.pop(next(iter(_KNOWN)), None)
    return known.functions[-1]


class _Known(NamedTuple):
    """What was traced for objects of one structure.

    Attributes:
        target: objects of the structure, which holds addresses of parts of them.
        functions: functions for different values of the numbers on which a formula branches.
    """

    target: Any
    functions: list[LiftedFunction]


_KNOWN: dict[Hashable, _Known] = {}
_MOST_KNOWN = 256


def _trace_with(
    values: NDArray[np.float64],
    name: str,
    formula: Formula,
    target: Any,
    shapes: Mapping[str, tuple[int, ...]],
    constants: tuple[type, ...],
) -> LiftedFunction:
    """Trace with as few numbers fixed as the branches of the formula allow."""
    fixed: dict[int, float] = {}
    while True:
        graph = Graph()
        try:
            return LiftedFunction(
                _traced(graph, name, formula, (target, constants, values, fixed), shapes), fixed
            )
        except DataDependentBranchError:
            more = _numbers_behind(graph.undecided) - fixed.keys()
            if not more:
                raise
            fixed |= {position: float(values[position]) for position in more}


def _traced(
    graph: Graph,
    name: str,
    formula: Formula,
    lifted: tuple[Any, tuple[type, ...], NDArray[np.float64], Mapping[int, float]],
    shapes: Mapping[str, tuple[int, ...]],
) -> SymbolicFunction:
    target, constants, values, fixed = lifted
    inputs = {each: SymbolicArray.inputs(graph, each, shape) for each, shape in shapes.items()}
    numbers = SymbolicArray.inputs(graph, _NUMBERS, values.shape)
    seen = numbers.copy()
    for position, value in fixed.items():
        seen[position] = value
    used = 0

    def symbolic(value: Any) -> Any:
        nonlocal used
        first, used = used, used + np.size(value)
        part = seen[first:used].reshape(np.shape(value))
        if all(node.is_constant for node in part.flat()):
            return value
        return part.copy()

    parts = _Walk(symbolic, constants).copied(target)
    results = formula(parts, **{each: array.copy() for each, array in inputs.items()})
    outputs: Symbols = {each: SymbolicArray.of(graph, value) for each, value in results.items()}
    return SymbolicFunction(name, {**inputs, _NUMBERS: numbers}, outputs)


def _numbers_behind(nodes: tuple[Node, ...]) -> set[int]:
    """Positions of the numbers on which nodes depend."""
    start = f"{_NUMBERS}["
    names = [node.name for node in reached(nodes) if node.is_input and node.name.startswith(start)]
    return {int(name[len(start) : -1]) for name in names}
