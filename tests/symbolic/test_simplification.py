"""Expression graphs: equal expressions are stored once, and simpler ones have the same values."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from prp_gym.symbolic.array import SymbolicArray
from prp_gym.symbolic.function import SymbolicFunction
from prp_gym.symbolic.graph import Graph, Node, reached
from prp_gym.symbolic.operations import (
    ADD,
    AND,
    COPY_SIGN,
    DIVIDE,
    EQUAL,
    LESS,
    MAXIMUM,
    MULTIPLY,
    NEGATIVE,
    NOT,
    OPERATIONS,
    OR,
    SINE,
    SUBTRACT,
    WHERE,
    Operation,
)
from tests.symbolic.compilation import arity

CONSTANTS = (0.0, -0.0, 1.0, -1.0, 2.5)
INPUTS = 3
LOGIC = (AND, OR, NOT)
OF_SIGNS = ("arctan2", "copysign")  # which tell zeros of both signs apart
VALUES = st.sampled_from([0.0, 1.0, -1.0, 0.75, -2.5, 3.25, 1e-3])
STEPS = st.lists(
    st.tuples(st.sampled_from(OPERATIONS), st.tuples(*[st.integers(0, 99)] * 3)), min_size=1, max_size=25
)


class Expressions:
    """Random expressions, each as a node and as the number that its operations give one by one.

    Args:
        values: numbers of the inputs.
    """

    def __init__(self, values: tuple[float, ...]) -> None:
        self.graph = Graph()
        self.inputs = SymbolicArray.inputs(self.graph, "x", (INPUTS,))
        leaves = [*self.inputs.flat(), *map(self.graph.constant, CONSTANTS)]
        self.nodes: list[Node] = leaves
        self.numbers = [*values, *CONSTANTS]
        self._truth_values = [CONSTANTS.index(0.0) + INPUTS, CONSTANTS.index(1.0) + INPUTS]

    def add(self, operation: Operation, choices: tuple[int, ...]) -> None:
        """Add the result of an operation, unless it is beyond what simplification takes for granted."""
        allowed = self._truth_values if operation in LOGIC else range(len(self.nodes))
        chosen = [allowed[choice % len(allowed)] for choice in choices[: arity(operation)]]
        numbers = [self.numbers[index] for index in chosen]
        number = operation.evaluate(*numbers)
        if math.isfinite(number) and not (operation.name in OF_SIGNS and 0.0 in numbers):
            if operation.boolean:
                self._truth_values.append(len(self.nodes))
            self.nodes.append(self.graph.apply(operation, *(self.nodes[index] for index in chosen)))
            self.numbers.append(number)


@settings(max_examples=200)
@given(values=st.tuples(*[VALUES] * INPUTS), steps=STEPS)
def test_simpler_expressions_have_the_same_values(
    values: tuple[float, ...], steps: list[tuple[Operation, tuple[int, ...]]]
) -> None:
    """Zeros may change their sign."""
    expressions = Expressions(values)
    for operation, choices in steps:
        expressions.add(operation, choices)
    nodes = np.array(expressions.nodes, dtype=object)
    outputs = {"y": SymbolicArray(expressions.graph, nodes)}
    function = SymbolicFunction("random", {"x": expressions.inputs}, outputs)
    found = function.evaluate({"x": np.array(values)})["y"]
    np.testing.assert_array_equal(found, expressions.numbers)


Rule = Callable[[Graph, Node, Node], Node]
"""An expression of a graph, a number and a truth value."""

SIMPLER_THAN_THE_NUMBER: dict[str, Rule] = {
    "zero_added": lambda g, x, _: g.apply(ADD, 0.0, g.apply(ADD, x, -0.0)),
    "zero_subtracted": lambda g, x, _: g.apply(SUBTRACT, x, 0.0),
    "times_one": lambda g, x, _: g.apply(MULTIPLY, 1.0, g.apply(MULTIPLY, x, 1.0)),
    "over_one": lambda g, x, _: g.apply(DIVIDE, x, 1.0),
    "negative_twice": lambda g, x, _: g.apply(MULTIPLY, -1.0, g.apply(SUBTRACT, 0.0, x)),
    "known_choice": lambda g, x, _: g.apply(WHERE, 0.0, 2.0, g.apply(WHERE, 1.0, x, 3.0)),
    "no_choice": lambda g, x, c: g.apply(WHERE, c, x, x),
}
SIMPLER_THAN_THE_TRUTH_VALUE: dict[str, Rule] = {
    "and_true": lambda g, _, c: g.apply(AND, 1.0, g.apply(AND, c, 1.0)),
    "or_false": lambda g, _, c: g.apply(OR, 0.0, g.apply(OR, c, 0.0)),
    "and_itself": lambda g, _, c: g.apply(AND, c, g.apply(OR, c, c)),
    "not_twice": lambda g, _, c: g.apply(NOT, g.apply(NOT, c)),
}
ZERO: dict[str, Rule] = {
    "times_zero": lambda g, x, _: g.apply(ADD, g.apply(MULTIPLY, x, 0.0), g.apply(MULTIPLY, -0.0, x)),
    "zero_over": lambda g, x, _: g.apply(DIVIDE, 0.0, x),
    "and_false": lambda g, _, c: g.apply(AND, c, 0.0),
    "not_or_true": lambda g, _, c: g.apply(NOT, g.apply(OR, c, 1.0)),
}


def number_and_truth_value() -> tuple[Graph, Node, Node]:
    graph = Graph()
    x = graph.input("x[0]")
    return graph, x, graph.apply(LESS, x, 1.0)


@pytest.mark.parametrize("name", SIMPLER_THAN_THE_NUMBER)
def test_expressions_that_equal_a_number_are_that_number(name: str) -> None:
    graph, x, condition = number_and_truth_value()
    assert SIMPLER_THAN_THE_NUMBER[name](graph, x, condition) is x


@pytest.mark.parametrize("name", SIMPLER_THAN_THE_TRUTH_VALUE)
def test_expressions_that_equal_a_truth_value_are_that_truth_value(name: str) -> None:
    graph, x, condition = number_and_truth_value()
    assert SIMPLER_THAN_THE_TRUTH_VALUE[name](graph, x, condition) is condition


@pytest.mark.parametrize("name", ZERO)
def test_expressions_that_are_zero_are_the_constant(name: str) -> None:
    graph, x, condition = number_and_truth_value()
    assert ZERO[name](graph, x, condition) is graph.constant(0.0)


LOGIC_OF_NUMBERS: dict[str, Callable[[Graph, Node], Node]] = {
    "and_true": lambda g, x: g.apply(AND, 1.0, x),
    "or_false": lambda g, x: g.apply(OR, x, 0.0),
    "and_itself": lambda g, x: g.apply(AND, x, x),
    "or_itself": lambda g, x: g.apply(OR, x, x),
    "not_twice": lambda g, x: g.apply(NOT, g.apply(NOT, x)),
}


@pytest.mark.parametrize("name", LOGIC_OF_NUMBERS)
def test_logic_of_numbers_gives_truth_values(name: str) -> None:
    graph = Graph()
    inputs = SymbolicArray.inputs(graph, "x", (1,))
    node = LOGIC_OF_NUMBERS[name](graph, inputs.flat()[0])
    outputs = {"y": SymbolicArray(graph, np.array([node], dtype=object))}
    function = SymbolicFunction("logic", {"x": inputs}, outputs)
    found = [float(function.evaluate({"x": np.array([x])})["y"][0]) for x in (0.0, 0.5, -2.0)]
    assert found == [0.0, 1.0, 1.0]


def test_equal_expressions_are_stored_once() -> None:
    graph = Graph()
    x, y = graph.input("x[0]"), graph.input("x[1]")
    assert graph.input("x[0]") is x
    assert graph.constant(2.5) is graph.lift(2.5)
    once = graph.apply(SINE, x * y + 2.5)
    count = len(graph.nodes)
    assert graph.apply(SINE, x * y + 2.5) is once
    assert len(graph.nodes) == count


@pytest.mark.parametrize(
    "operation", [ADD, MULTIPLY, MAXIMUM, EQUAL, AND], ids=lambda operation: operation.name
)
def test_order_of_arguments_is_irrelevant_where_operations_commute(operation: Operation) -> None:
    graph = Graph()
    x, y = graph.input("x[0]"), graph.input("x[1]")
    assert graph.apply(operation, x, y) is graph.apply(operation, y, x)


@pytest.mark.parametrize(
    "operation", [SUBTRACT, DIVIDE, LESS, COPY_SIGN], ids=lambda operation: operation.name
)
def test_order_of_arguments_is_kept_elsewhere(operation: Operation) -> None:
    graph = Graph()
    x, y = graph.input("x[0]"), graph.input("x[1]")
    assert graph.apply(operation, x, y) is not graph.apply(operation, y, x)


def test_zeros_of_both_signs_are_different_constants() -> None:
    graph = Graph()
    positive, negative = graph.constant(0.0), graph.constant(-0.0)
    assert positive is not negative
    assert [math.copysign(1.0, node.value) for node in (positive, negative)] == [1.0, -1.0]
    assert graph.apply(COPY_SIGN, 2.0, negative).value == -2.0
    assert graph.apply(NEGATIVE, positive) is negative


def test_operations_on_constants_are_constants() -> None:
    graph = Graph()
    assert graph.apply(ADD, 0.1, 0.2) is graph.constant(0.1 + 0.2)
    assert graph.apply(LESS, 1.0, 2.0) is graph.constant(1.0)
    assert graph.apply(DIVIDE, 1.0, 0.0).value == math.inf


def test_every_node_stands_after_its_arguments() -> None:
    graph = Graph()
    x, y = graph.input("x[0]"), graph.input("x[1]")
    unused, result = graph.apply(SINE, y), -(x * x + y) / x
    found = reached([result, x])
    assert unused not in found
    assert found[-1] is result
    for index, node in enumerate(found):
        assert set(node.arguments) <= set(found[:index])
