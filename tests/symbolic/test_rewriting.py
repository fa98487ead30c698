"""Functions made from others: inputs that become constants, and expressions that are replaced."""

import numpy as np
import pytest

from prp_gym.symbolic.function import SymbolicFunction, trace
from prp_gym.symbolic.operations import ADD, SUBTRACT
from prp_gym.symbolic.rewriting import rewritten, with_constants


def line() -> SymbolicFunction:
    """a·x + b, and b alone."""
    return trace("line", lambda a, b, x: {"y": a * x + b, "b": b}, {"a": (2,), "b": (2,), "x": (2,)})


def test_inputs_become_constants_and_what_is_known_is_computed() -> None:
    function = with_constants(line(), "folded", a=[1.0, 2.0], b=np.array([0.0, 3.0]))
    assert function.name == "folded"
    assert list(function.inputs) == ["x"]
    found = function.evaluate({"x": np.array([5.0, 7.0])})
    np.testing.assert_array_equal(found["y"], [5.0, 17.0])
    np.testing.assert_array_equal(found["b"], [0.0, 3.0])
    first = function.outputs["y"].flat()[0]
    assert first.name == "x[0]"  # 1·x + 0
    assert sum(node.operation is not None for node in function.nodes()) == 2


def test_every_input_needs_a_number_for_each_component() -> None:
    with pytest.raises(ValueError, match="zip"):
        with_constants(line(), "folded", a=[1.0])


def test_expressions_are_replaced_after_their_arguments_and_the_function_is_left_as_it_was() -> None:
    function = line()
    other = rewritten(
        function,
        "other",
        lambda graph, node, parts: graph.apply(SUBTRACT, *parts) if node.operation is ADD else None,
    )
    values = {"a": np.array([2.0, 3.0]), "b": np.array([1.0, 1.0]), "x": np.array([5.0, 7.0])}
    assert list(other.inputs) == list(function.inputs)
    # the order of the terms of a sum is that of the graph
    np.testing.assert_array_equal(np.abs(other.evaluate(values)["y"]), [9.0, 20.0])
    np.testing.assert_array_equal(function.evaluate(values)["y"], [11.0, 22.0])
