"""Functions of named arrays as expression graphs, traced from formulas that are written with NumPy."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from prp_gym.symbolic.array import SymbolicArray
from prp_gym.symbolic.graph import Graph, Node, reached

Symbols = Mapping[str, SymbolicArray]


@dataclass(frozen=True, eq=False)
class SymbolicFunction:
    """A function from named arrays to named arrays.

    Attributes:
        name: name of the function, rare enough for a C function.
        inputs: arguments by name, each an array of inputs.
        outputs: results by name.
    """

    name: str
    inputs: Symbols
    outputs: Symbols

    def nodes(self) -> list[Node]:
        """Everything that has to be computed, in order."""
        return reached(node for array in self.outputs.values() for node in array.flat())

    @cached_property
    def is_exact(self) -> bool:
        """Whether every machine gives the same bits, which sines and the like may differ in."""
        return all(node.operation is None or node.operation.exact for node in self.nodes())

    def evaluate(self, values: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
        """The results of numbers, one operation of NumPy after the other; slow, for tests.

        Args:
            values: arguments by name, of the inputs' shapes.
        """
        known = {
            node: float(number)
            for name, array in self.inputs.items()
            for node, number in zip(array.flat(), np.ravel(values[name]), strict=True)
        }
        for node in self.nodes():
            if node.operation is not None:
                known[node] = node.operation.evaluate(*(known[argument] for argument in node.arguments))
            elif node.is_constant:
                known[node] = node.value
        return {
            name: np.array([known[node] for node in array.flat()]).reshape(array.shape)
            for name, array in self.outputs.items()
        }

    def evaluate_rows(self, values: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
        """The results of arrays of numbers, with the bits of the compiled function.

        Args:
            values: arguments by name, of the inputs' shapes after common leading dimensions.
        """
        known: dict[Node, np.ndarray] = {}
        lead: tuple[int, ...] = ()
        for name, array in self.inputs.items():
            given = np.asarray(values[name])
            lead = given.shape[: given.ndim - array.ndim]
            columns = given.reshape((*lead, array.size))
            known |= {node: columns[..., index] for index, node in enumerate(array.flat())}
        for node in self.nodes():
            if node.operation is not None:
                known[node] = node.operation.of_arrays(*(known[argument] for argument in node.arguments))
            elif node.is_constant:
                known[node] = np.asarray(node.value)
        return {
            name: np.stack([np.broadcast_to(known[node], lead) for node in array.flat()], axis=-1).reshape(
                (*lead, *array.shape)
            )
            for name, array in self.outputs.items()
        }


def trace(
    name: str, formula: Callable[..., Mapping[str, SymbolicArray]], shapes: Mapping[str, tuple[int, ...]]
) -> SymbolicFunction:
    """Trace a formula.

    Args:
        name: name of the function.
        formula: takes symbolic arrays by the names of `shapes` and returns its results by name.
        shapes: shapes of the arguments.

    Raises:
        UntraceableError: a formula that uses more than arithmetic on arrays.
        DataDependentBranchError: one that branches on its arguments.
    """
    graph = Graph()
    inputs = {each: SymbolicArray.inputs(graph, each, shape) for each, shape in shapes.items()}
    results = formula(**{each: array.copy() for each, array in inputs.items()})  # which it may overwrite
    return SymbolicFunction(
        name, inputs, {each: SymbolicArray.of(graph, value) for each, value in results.items()}
    )
