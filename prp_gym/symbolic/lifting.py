"""Functions traced from methods of objects, with the numbers that the objects hold as inputs.

A controller holds gains, a task scales and bounds. Where these are inputs and no constants, one compiled
function serves every controller and every task of a kind, and it has derivatives by its gains.
"""

from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from prp_gym.errors import DataDependentBranchError, UntraceableError, shortened
from prp_gym.symbolic.array import SymbolicArray
from prp_gym.symbolic.function import SymbolicFunction, Symbols
from prp_gym.symbolic.graph import Graph, Node, reached, value_of
from prp_gym.symbolic.number_walk import NumberWalk

Formula = Callable[..., Mapping[str, Any]]
_NUMBERS = "numbers"


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

    NumberWalk(keep, constants).copied(target)
    return np.concatenate([np.zeros(0), *found])


def structure_of(target: Any, constants: tuple[type, ...] = ()) -> tuple[Hashable, ...]:
    """What objects are apart from their numbers."""
    walk = NumberWalk(lambda value: value, constants)
    walk.copied(target)
    return tuple(walk.structure)


@dataclass(frozen=True, eq=False)
class LiftedFunction:
    """A function traced from methods of objects, with their numbers as the input `numbers` (P).

    Attributes:
        function: the function.
        fixed: numbers on which the formula branches, with the values for which it was traced, by their
            positions; of them the function does not depend.
        decisions: conditions on the numbers that were decided by these, with their outcomes.
    """

    function: SymbolicFunction
    fixed: Mapping[int, float]
    decisions: Mapping[Node, bool] = field(default_factory=dict)

    def serves(self, numbers: NDArray[np.float64]) -> bool:
        """Whether the function is that of other objects of the same structure, with these numbers (P)."""
        if any(float(numbers[position]).hex() != value.hex() for position, value in self.fixed.items()):
            return False
        if not self.decisions:
            return True
        known = _known_numbers(self.function.inputs[_NUMBERS], numbers)
        return all(value_of(node, known) == outcome for node, outcome in self.decisions.items())


def trace_method(
    name: str,
    formula: Formula,
    target: Any,
    shapes: Mapping[str, tuple[int, ...]],
    constants: tuple[type, ...] = (),
    kind: Hashable = None,
    *,
    decide: bool = False,
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
        decide: whether a branch on numbers alone is decided by these, which stay inputs.

    Returns:
        the function of the arguments and of `numbers`. A number on which the formula branches otherwise is a
        constant.

    Raises:
        UntraceableError: a formula that uses more than arithmetic on arrays, or fails on symbolic ones.
        DataDependentBranchError: one that branches on its arguments.
    """
    values = numbers_of(target, constants)
    if kind is None:
        return _trace_with(values, name, formula, target, shapes, constants, decide)
    key = name, kind, decide, tuple(shapes.items()), structure_of(target, constants)
    known = _KNOWN.get(key, [])
    found = next((each for each in known if each.serves(values)), None)
    if found is None:
        found = _trace_with(values, name, formula, target, shapes, constants, decide)
        known = [*known, found][-_MOST_BRANCHES:]
    _KNOWN.pop(key, None)
    _KNOWN[key] = known  # the latest last
    while len(_KNOWN) > _MOST_KNOWN:
        _KNOWN.pop(next(iter(_KNOWN)), None)
    return found


_KNOWN: dict[Hashable, list[LiftedFunction]] = {}
_MOST_KNOWN = 256  # structures
_MOST_BRANCHES = 16  # functions of one structure


def _trace_with(
    values: NDArray[np.float64],
    name: str,
    formula: Formula,
    target: Any,
    shapes: Mapping[str, tuple[int, ...]],
    constants: tuple[type, ...],
    decide: bool,
) -> LiftedFunction:
    """Trace with as few numbers fixed as the branches of the formula allow."""
    fixed: dict[int, float] = {}
    while True:
        graph = Graph()
        try:
            function = _traced(graph, name, formula, (target, constants, values, fixed), shapes, decide)
            return LiftedFunction(function, fixed, dict(graph.decisions))
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
    decide: bool,
) -> SymbolicFunction:
    target, constants, values, fixed = lifted
    inputs = {each: SymbolicArray.inputs(graph, each, shape) for each, shape in shapes.items()}
    numbers = SymbolicArray.inputs(graph, _NUMBERS, values.shape)
    if decide:
        graph.known = _known_numbers(numbers, values)
    seen = numbers.copy()
    for position, value in fixed.items():
        seen[position] = value
    used = 0

    def symbolic(value: Any) -> Any:
        nonlocal used
        first, used = used, used + np.size(value)
        part = seen[first:used].reshape(np.shape(value))
        if all(node.is_constant for node in part.flat()):
            return value.copy() if isinstance(value, np.ndarray) else value
        return part.copy()

    parts = NumberWalk(symbolic, constants).copied(target)
    try:
        results = formula(parts, **{each: array.copy() for each, array in inputs.items()})
        outputs: Symbols = {each: SymbolicArray.of(graph, value) for each, value in results.items()}
    except UntraceableError:
        raise
    except Exception as error:  # a method that symbolic arrays lack, a check of values that are not known
        failed = f"{type(error).__name__}: {shortened(str(error))}"
        raise UntraceableError(f"{name} cannot be traced into compiled code: {failed}") from error
    return SymbolicFunction(name, {**inputs, _NUMBERS: numbers}, outputs)


def _known_numbers(inputs: SymbolicArray, values: NDArray[np.float64]) -> dict[Node, float]:
    return dict(zip(inputs.flat(), values.tolist(), strict=True))


def _numbers_behind(nodes: tuple[Node, ...]) -> set[int]:
    """Positions of the numbers on which nodes depend."""
    start = f"{_NUMBERS}["
    names = [node.name for node in reached(nodes) if node.is_input and node.name.startswith(start)]
    return {int(name[len(start) : -1]) for name in names}
