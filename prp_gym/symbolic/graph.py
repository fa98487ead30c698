"""Expression graphs: scalar operations on inputs and constants, every expression stored once."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

from prp_gym.symbolic.operations import ADD, DIVIDE, MULTIPLY, NEGATIVE, SUBTRACT, Operation
from prp_gym.symbolic.simplification import simplified


class Node:
    """One scalar of a graph: a constant, an input, or an operation on other scalars.

    Nodes are made by their graph alone, which holds each once, so that equal nodes are the same object.

    Attributes:
        graph: graph to which the node belongs.
        index: position in the graph, above those of the arguments.
        operation: operation whose result this is; None for a constant or an input.
        arguments: nodes on which the operation works.
        value: value of a constant; NaN for all else.
        name: name of an input, as it stands in generated code; empty for all else.
    """

    __slots__ = ("arguments", "graph", "index", "name", "operation", "value")

    def __init__(
        self,
        graph: Graph,
        operation: Operation | None,
        arguments: tuple[Node, ...] = (),
        value: float = math.nan,
        name: str = "",
    ) -> None:
        self.graph, self.index = graph, len(graph.nodes)
        self.operation, self.arguments = operation, arguments
        self.value, self.name = value, name
        graph.nodes.append(self)

    def __repr__(self) -> str:
        if self.operation is None:
            return self.name or repr(self.value)
        return f"{self.operation.name}({', '.join(f'#{node.index}' for node in self.arguments)})"

    @property
    def is_constant(self) -> bool:
        """Whether this is a constant."""
        return self.operation is None and not self.name

    @property
    def is_input(self) -> bool:
        """Whether this is an input."""
        return bool(self.name)

    @property
    def is_boolean(self) -> bool:
        """Whether this is a truth value, 0 or 1."""
        return self.operation is not None and self.operation.boolean

    def __add__(self, other: Node | float) -> Node:
        return self.graph.apply(ADD, self, other)

    def __sub__(self, other: Node | float) -> Node:
        return self.graph.apply(SUBTRACT, self, other)

    def __mul__(self, other: Node | float) -> Node:
        return self.graph.apply(MULTIPLY, self, other)

    def __truediv__(self, other: Node | float) -> Node:
        return self.graph.apply(DIVIDE, self, other)

    def __neg__(self) -> Node:
        return self.graph.apply(NEGATIVE, self)


class Graph:
    """The expressions of one trace.

    Attributes:
        nodes: all nodes, in an order in which every node stands after its arguments.
        undecided: nodes of the condition on which a formula last branched and which was not known.
        known: numbers of inputs; a branch on these alone is decided by them.
        decisions: conditions that were decided so, with their outcomes.
    """

    def __init__(self) -> None:
        self.nodes: list[Node] = []
        self.undecided: tuple[Node, ...] = ()
        self.known: dict[Node, float] = {}
        self.decisions: dict[Node, bool] = {}
        self._constants: dict[str, Node] = {}
        self._inputs: dict[str, Node] = {}
        self._results: dict[tuple[Operation, tuple[Node, ...]], Node] = {}

    def constant(self, value: float) -> Node:
        """The node of a number; zeros of both signs are different numbers."""
        key = float(value).hex()
        if key not in self._constants:
            self._constants[key] = Node(self, None, value=float(value))
        return self._constants[key]

    def input(self, name: str) -> Node:
        """The node of an input."""
        if name not in self._inputs:
            self._inputs[name] = Node(self, None, name=name)
        return self._inputs[name]

    def lift(self, value: Node | float) -> Node:
        """A number as a node; a node as it is."""
        return value if isinstance(value, Node) else self.constant(value)

    def decide(self, condition: Node) -> bool | None:
        """The outcome of a condition on known inputs, which is noted; None for one on others."""
        value = value_of(condition, self.known)
        if value is None:
            return None
        return self.decisions.setdefault(condition, bool(value))

    def apply(self, operation: Operation, *values: Node | float) -> Node:
        """The result of an operation; a known or simpler equal node where there is one."""
        arguments = tuple(self.lift(value) for value in values)
        simple = simplified(operation, arguments)
        if simple is not None:
            return self.lift(simple)
        if operation.commutes and arguments[0].index > arguments[1].index:
            arguments = arguments[1], arguments[0]
        key = operation, arguments
        if key not in self._results:
            self._results[key] = Node(self, operation, arguments)
        return self._results[key]


def reached(outputs: Iterable[Node]) -> list[Node]:
    """The nodes on which some depend, these included, every one after its arguments."""
    found: set[Node] = set()
    waiting = list(outputs)
    while waiting:
        node = waiting.pop()
        if node not in found:
            found.add(node)
            waiting.extend(node.arguments)
    return sorted(found, key=lambda node: node.index)


def value_of(output: Node, known: Mapping[Node, float]) -> float | None:
    """The value of a node where the inputs have these numbers; None if it depends on others."""
    values: dict[Node, float] = {}
    for node in reached((output,)):
        if node.is_input:
            if node not in known:
                return None
            values[node] = known[node]
        elif node.operation is None:
            values[node] = node.value
        else:
            values[node] = node.operation.evaluate(*(values[argument] for argument in node.arguments))
    return values[output]
