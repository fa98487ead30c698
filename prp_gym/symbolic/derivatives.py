"""Exact derivatives of symbolic functions, by reverse accumulation over the expression graph."""

from collections.abc import Mapping
from functools import lru_cache

import numpy as np

from prp_gym.symbolic.array import SymbolicArray
from prp_gym.symbolic.function import SymbolicFunction
from prp_gym.symbolic.graph import Graph, Node, reached
from prp_gym.symbolic.operations import SINGLE
from prp_gym.symbolic.rewriting import rewritten


def adjoints(seeds: Mapping[Node, Node | float]) -> dict[Node, Node]:
    """Derivatives of Σ seed·result by every node on which a result depends.

    At a switch, the edge of a `where`, `minimum` or `maximum`, the derivative is that of the branch taken.

    Args:
        seeds: weight of every result in the sum.

    Source: Griewank 2008, 3.2.
    """
    derivative: dict[Node, Node] = {}

    def add(node: Node, amount: Node | float) -> None:
        known = derivative.get(node)
        derivative[node] = node.graph.lift(amount) if known is None else known + amount

    for node, weight in seeds.items():
        add(node, weight)
    for node in reversed(reached(seeds)):
        operation, own = node.operation, derivative.get(node)
        if own is None or operation is None or operation.adjoint is None:
            continue
        amounts = operation.adjoint(own, node, *node.arguments)
        for argument, amount in zip(node.arguments, amounts, strict=True):
            add(argument, amount)
    return derivative


def jacobian(outputs: SymbolicArray, inputs: SymbolicArray) -> SymbolicArray:
    """Derivatives of some expressions by some inputs (outputs.size, inputs.size)."""
    graph = outputs.graph
    rows = [_gradient(graph, adjoints({node: 1.0}), inputs.flat()) for node in outputs.flat()]
    nodes = np.empty((len(rows), inputs.size), dtype=object)
    for index, row in enumerate(rows):
        nodes[index] = row
    return SymbolicArray(graph, nodes)


@lru_cache(maxsize=64)
def transposed(function: SymbolicFunction, name: str, wanted: tuple[str, ...]) -> SymbolicFunction:
    """The transposed Jacobian of a function times a vector: one step of reverse accumulation.

    Args:
        function: function f.
        name: name of the new function.
        wanted: inputs x by which f is differentiated.

    Returns:
        A function of the inputs of f, and of `d_<output>` for the weight of every output, with the results
        `d_<input>` = Σ (∂output/∂input)ᵀ d_<output> of the wanted inputs.
    """
    graph = next(iter(function.outputs.values())).graph
    weights = {
        f"d_{each}": SymbolicArray.inputs(graph, f"d_{each}", array.shape)
        for each, array in function.outputs.items()
    }
    seeds: dict[Node, Node | float] = {}
    for each, array in function.outputs.items():
        for node, weight in zip(array.flat(), weights[f"d_{each}"].flat(), strict=True):
            seeds[node] = weight + seeds[node] if node in seeds else weight
    derivative = adjoints(seeds)
    results = {}
    for each in wanted:
        array = function.inputs[each]
        nodes = np.array(_gradient(graph, derivative, array.flat()), dtype=object).reshape(array.shape)
        results[f"d_{each}"] = SymbolicArray(graph, nodes)
    return SymbolicFunction(name, {**function.inputs, **weights}, results)


@lru_cache(maxsize=64)
def unrounded(function: SymbolicFunction, name: str) -> SymbolicFunction:
    """A function without its rounding to single precision, and so one that is as smooth as its formula.

    Args:
        function: function.
        name: name of the new function.
    """
    return rewritten(function, name, _without_rounding)


def _without_rounding(_: Graph, node: Node, arguments: tuple[Node, ...]) -> Node | None:
    return arguments[0] if node.operation is SINGLE else None


def _gradient(graph: Graph, derivative: Mapping[Node, Node], inputs: list[Node]) -> list[Node]:
    """The derivatives by some inputs; zero for those without effect."""
    return [derivative.get(node, graph.constant(0.0)) for node in inputs]
