"""Symbolic functions made from others by replacing some of their expressions."""

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import ArrayLike

from prp_gym.symbolic.array import SymbolicArray
from prp_gym.symbolic.function import SymbolicFunction
from prp_gym.symbolic.graph import Graph, Node

Replace = Callable[[Graph, Node, tuple[Node, ...]], Node | None]
"""From the new graph, an old node and its rewritten arguments: what replaces it; None to keep it."""


def rewritten(function: SymbolicFunction, name: str, replace: Replace) -> SymbolicFunction:
    """A function whose expressions are replaced one by one, each after its arguments.

    Args:
        function: function.
        name: name of the new function.
        replace: what replaces an expression.

    Returns:
        a function in a graph of its own, with the same inputs and outputs.
    """
    graph, known = Graph(), dict[Node, Node]()
    for node in function.nodes():
        arguments = tuple(known[argument] for argument in node.arguments)
        new = replace(graph, node, arguments)
        known[node] = _kept(graph, node, arguments) if new is None else new
    inputs = {each: SymbolicArray.inputs(graph, each, array.shape) for each, array in function.inputs.items()}
    outputs = {each: _replaced(graph, array, known) for each, array in function.outputs.items()}
    return SymbolicFunction(name, inputs, outputs)


def with_constants(function: SymbolicFunction, name: str, **values: ArrayLike) -> SymbolicFunction:
    """A function of fewer inputs: some of them are numbers, with which all that is known is computed.

    Args:
        function: function.
        name: name of the new function.
        values: numbers of the inputs that become constants, by name, of the inputs' shapes.
    """
    numbers = {
        node.name: float(number)
        for each, value in values.items()
        for node, number in zip(function.inputs[each].flat(), np.ravel(value), strict=True)
    }

    def replace(graph: Graph, node: Node, _: tuple[Node, ...]) -> Node | None:
        return graph.constant(numbers[node.name]) if node.name in numbers else None

    new = rewritten(function, name, replace)
    inputs = {each: array for each, array in new.inputs.items() if each not in values}
    return SymbolicFunction(name, inputs, new.outputs)


def _kept(graph: Graph, node: Node, arguments: tuple[Node, ...]) -> Node:
    if node.is_input:
        return graph.input(node.name)
    if node.operation is None:
        return graph.constant(node.value)
    return graph.apply(node.operation, *arguments)


def _replaced(graph: Graph, array: SymbolicArray, known: Mapping[Node, Node]) -> SymbolicArray:
    nodes = np.empty(array.size, dtype=object)
    nodes[:] = [known[node] for node in array.flat()]
    return SymbolicArray(graph, nodes.reshape(array.shape))
