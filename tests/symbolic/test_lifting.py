"""Functions with the numbers of objects as inputs: one for all objects alike, whatever it branches on."""

import math
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from prp_gym.errors import DataDependentBranchError, UntraceableError
from prp_gym.symbolic import lifting
from prp_gym.symbolic.lifting import LiftedFunction, numbers_of, trace_method
from tests.symbolic.compilation import compile_together
from tests.symbolic.objects import Bounds, Filter, Holder, Line, X, result, traced

pytestmark = pytest.mark.usefixtures("nothing_known")


class Loop:
    """A controller in miniature, with numbers of many kinds.

    Args:
        generator: random generator of its numbers.
    """

    def __init__(self, generator: np.random.Generator) -> None:
        self.gains = generator.normal(size=(2, 3))
        self.filter = Filter(float(generator.uniform(0.1, 0.9)))
        self.bounds = Bounds(*np.sort(generator.normal(size=2)).tolist())
        self.weights: dict[str, Any] = {"a": generator.normal(), "b": [generator.normal(size=3), "unused"]}
        self.line = Line(generator.normal()).value
        self.reverse = np.array([2, 0, 1])

    def control(self, x: Any) -> Any:
        low, high = self.bounds
        error = np.clip(x, low, high) * self.gains[0] + self.gains[1]
        smooth = self.filter.rate * self.filter.order * error + self.weights["a"] * x[self.reverse]
        return np.where(smooth > 0.0, self.line(smooth), smooth / self.weights["b"][0])


def test_one_function_serves_all_objects_alike_with_the_numbers_of_numpy() -> None:
    generator = np.random.default_rng(0)
    loops = [Loop(generator) for _ in range(20)]
    functions = {traced(lambda loop, x: loop.control(x), loop) for loop in loops}
    (lifted,) = functions
    assert lifted.fixed == {}
    code = compile_together([lifted.function])["formula"]
    for loop in loops:
        numbers, x = numbers_of(loop), generator.normal(size=3)
        assert numbers.shape == (14,)
        expected = loop.control(x)
        np.testing.assert_array_equal(code({"x": x, "numbers": numbers})["y"], expected)
        np.testing.assert_array_equal(result(lifted, loop, x), expected)


def limited(target: Any, x: Any) -> Any:
    return target.gain * x if target.limit > 1.0 else target.gain + x


def test_a_number_on_which_the_formula_branches_is_fixed_alone() -> None:
    low, high = Holder(gain=3.0, limit=0.5, other=7.0), Holder(gain=5.0, limit=2.0, other=8.0)
    functions = [traced(limited, target) for target in (low, high)]
    assert [lifted.fixed for lifted in functions] == [{1: 0.5}, {1: 2.0}]
    np.testing.assert_array_equal(result(functions[0], low), 3.0 + X)
    np.testing.assert_array_equal(result(functions[1], high), 5.0 * X)
    # both are known now, each for its number and any gain
    for lifted, target in zip(functions, (low, high), strict=True):
        target.gain = -1.0
        assert traced(limited, target) is lifted
    np.testing.assert_array_equal(result(functions[0], low), -1.0 + X)
    assert not functions[0].serves(numbers_of(high))
    assert not functions[1].serves(numbers_of(low))
    # a number on the same side is another one all the same
    assert not functions[1].serves(numbers_of(Holder(gain=5.0, limit=3.0, other=8.0)))


FIXED: dict[str, tuple[Callable[[Any, Any], Any], set[int]]] = {
    "none": (lambda t, x: np.where(t.a > t.b, x, t.c) + t.row, set()),
    "sum": (lambda t, x: t.c * x if t.a + 2.0 * t.b > 0.0 else x, {0, 1}),
    "only_the_branch_taken": (lambda t, x: x if t.a > 0.0 or t.b > 0.0 else -x, {0}),
    "both_in_turn": (lambda t, x: x if t.a > 0.0 and t.b > 0.0 else -x, {0, 1}),
    "rest_of_a_fixed_array": (lambda t, x: x * t.row if t.row[1] > 0.0 else x, {4}),
    "whole_array": (lambda t, x: x if (t.row > 0.0).any() else t.c * x, {3, 4, 5}),
    "truth_value": (lambda t, x: x if t.c else -x, {2}),
    "float": (lambda t, x: float(t.b) * x, {1}),
    "function_of_math": (lambda t, x: math.exp(-t.a * t.c) * x + t.b, {0, 2}),
    "float_of_an_element": (lambda t, x: float(t.row[2]) * x * t.row, {5}),
    "smallest": (lambda t, x: min(t.a, t.b) * x, {0, 1}),
    "numbers_of_a_product_with_zero": (lambda t, x: x if 0.0 * t.a + t.b > 0.0 else -x, {1}),
}


@pytest.mark.parametrize("name", FIXED)
def test_no_more_is_fixed_than_the_branches_need(name: str) -> None:
    formula, positions = FIXED[name]
    target = Holder(a=0.5, b=1.5, c=-2.5, row=np.array([0.25, 4.0, -1.25]))
    lifted = traced(formula, target)
    numbers = numbers_of(target)
    assert lifted.fixed == {position: numbers[position] for position in positions}
    np.testing.assert_array_equal(result(lifted, target), formula(target, X))
    inputs = {node.name for node in lifted.function.nodes() if node.is_input}
    assert inputs.isdisjoint(f"numbers[{position}]" for position in positions)


SPECIAL = (math.nan, math.inf, 0.0, -0.0)


@pytest.mark.parametrize("number", SPECIAL)
def test_a_fixed_number_is_told_from_every_other(number: float) -> None:
    def formula(target: Any, x: Any) -> Any:
        return math.copysign(1.0, target.gain) * x if target.gain == target.gain else x

    lifted = traced(formula, Holder(gain=number))
    assert traced(formula, Holder(gain=number)) is lifted
    served = [other for other in SPECIAL if lifted.serves(np.array([other]))]
    np.testing.assert_array_equal(served, [number])
    assert np.signbit(served).tolist() == [bool(np.signbit(number))]


ON_DATA: dict[str, Callable[[Any, Any], Any]] = {
    "alone": lambda t, x: x if x[0] > 0.0 else -x,
    "with_a_number": lambda t, x: x if x[0] > t.gain else -x,
    "after_a_number": lambda t, x: x if t.gain > 0.0 and x[0] > 0.0 else -x,
    "with_a_fixed_number": lambda t, x: x if t.gain > 0.0 and x[0] > t.gain else -x,
    "float": lambda t, x: float(t.gain * x[0]) * x,
    "function_of_math": lambda t, x: math.exp(t.gain + x[0]) * x,
}


@pytest.mark.parametrize("name", ON_DATA)
def test_a_branch_on_data_is_refused(name: str) -> None:
    with pytest.raises(DataDependentBranchError, match="cannot be traced into compiled code"):
        traced(ON_DATA[name], Holder(gain=0.5))


def test_formulas_are_told_apart_by_kind_name_and_shapes() -> None:
    target, formula = Holder(gain=2.0), lambda target, x: {"y": target.gain * x}

    def of(name: str, size: int, kind: Any) -> LiftedFunction:
        return trace_method(name, formula, target, {"x": (size,)}, kind=kind)

    functions = [of("a", 3, 1), of("b", 3, 1), of("a", 2, 1), of("a", 3, 2)]
    assert len(set(functions)) == 4
    assert [of("a", 3, 1), of("b", 3, 1), of("a", 2, 1), of("a", 3, 2)] == functions
    assert of("a", 3, None) is not of("a", 3, None)
    assert of("a", 3, None) not in functions


def test_only_the_latest_structures_are_known(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lifting, "_MOST_KNOWN", 3)
    functions = [traced(lambda _, x: x, Holder(order=order)) for order in range(3)]
    assert traced(lambda _, x: x, Holder(order=0)) is functions[0]  # the latest now
    traced(lambda _, x: x, Holder(order=3))
    assert len(lifting._KNOWN) == 3
    known = [traced(lambda _, x: x, Holder(order=order)) is functions[order] for order in (2, 0, 1)]
    assert known == [True, True, False]


def test_only_some_values_of_a_fixed_number_are_known() -> None:
    for limit in range(100):
        latest = traced(limited, Holder(gain=1.0, limit=float(limit), other=0.0))
    ((known),) = lifting._KNOWN.values()
    assert 1 < len(known) < 50
    assert known[-1] is latest


def test_of_refused_formulas_nothing_is_known() -> None:
    for order in range(3):
        with pytest.raises(DataDependentBranchError):
            traced(ON_DATA["alone"], Holder(order=order))
    assert lifting._KNOWN == {}


def violent(target: Any, x: Any) -> Any:
    """Changes whatever it can."""
    value = target.gain * x if (target.row > 0.0).any() else x
    target.row[:] = 0.0
    target.gains[0] = x[0]
    target.gain, target.new = x, x
    target.line.slope = x[1]
    target.parts.append(target.table.pop("a"))
    target.counts[0] += 1
    target.chosen.add(5)
    target.generator.normal()
    object.__setattr__(target.filter, "rate", 0.0)
    return value + target.parts[-1]


def test_objects_are_not_changed_by_tracing() -> None:
    parts = {"gain": 2.0, "row": np.ones(2), "gains": np.ones(3), "line": Line(3.0), "parts": [1.0]}
    table = {"a": 4.0, "b": 5.0}
    rest = {"counts": np.zeros(2, dtype=int), "chosen": {1}, "filter": Filter(0.5), "table": table}
    target = Holder(**parts, **rest, generator=np.random.default_rng(0))
    before = pickle.dumps(target)
    lifted = traced(violent, target)
    assert pickle.dumps(target) == before
    assert set(lifted.fixed) == {1, 2}
    np.testing.assert_array_equal(result(lifted, target), 2.0 * X + 4.0)


def test_arguments_that_a_formula_overwrites_stay_its_inputs() -> None:
    def formula(target: Any, x: Any) -> Any:
        x[...] = target.gain * x[::-1]
        return x

    target = Holder(gain=2.0)
    lifted = traced(formula, target)
    assert [node.name for node in lifted.function.inputs["x"].flat()] == ["x[0]", "x[1]", "x[2]"]
    np.testing.assert_array_equal(result(lifted, target), 2.0 * X[::-1])


def failing(target: Any, x: Any) -> Any:
    raise LookupError("no such gain")


FAILING: dict[str, tuple[Callable[[Any, Any], Any], str]] = {
    "own_error": (failing, "formula cannot be traced into compiled code: LookupError: .*no such gain"),
    "method_that_symbolic_arrays_lack": (lambda t, x: x.cumsum(), "AttributeError.*cumsum"),
    "whole_number_of_data": (lambda t, x: int(x[0]) * x, "TypeError"),
    "result_without_numbers": (lambda t, x: ["none"], "ValueError"),
    "function_of_numpy": (lambda t, x: np.linalg.norm(x), r"^numpy\.norm cannot"),
}


@pytest.mark.parametrize("name", FAILING)
def test_formulas_that_fail_on_symbolic_arrays_are_refused(name: str) -> None:
    formula, message = FAILING[name]
    with pytest.raises(UntraceableError, match=message):
        traced(formula, Holder(gain=2.0))


def decided(formula: Callable[[Any, Any], Any], target: Any) -> LiftedFunction:
    """A formula whose branches on numbers are decided by these."""

    def results(parts: Any, x: Any) -> dict[str, Any]:
        return {"y": formula(parts, x)}

    return trace_method("formula", results, target, {"x": X.shape}, kind="kind", decide=True)


def test_a_branch_on_numbers_may_be_decided_by_them_and_leaves_them_inputs() -> None:
    def formula(target: Any, x: Any) -> Any:
        return target.limit * x if target.limit > target.gain else target.gain + x

    high, higher, low = (Holder(gain=1.0, limit=limit) for limit in (2.0, 3.0, 0.5))
    lifted = decided(formula, high)
    assert lifted.fixed == {}
    np.testing.assert_array_equal(result(lifted, high), 2.0 * X)
    assert decided(formula, higher) is lifted  # on the same side of the branch
    np.testing.assert_array_equal(result(lifted, higher), 3.0 * X)
    assert not lifted.serves(numbers_of(low))
    np.testing.assert_array_equal(result(decided(formula, low), low), 1.0 + X)
    assert traced(formula, high).fixed == {0: 1.0, 1: 2.0}  # unless asked for


def test_a_branch_on_the_arguments_is_decided_by_nothing() -> None:
    with pytest.raises(DataDependentBranchError):
        decided(lambda target, x: x if x[0] > target.gain else -x, Holder(gain=1.0))
