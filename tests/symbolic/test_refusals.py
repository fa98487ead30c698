"""What cannot be traced is refused, by name, rather than traced wrongly."""

import math
import operator
import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from prp_gym.errors import DataDependentBranchError, UntraceableError
from prp_gym.symbolic.function import trace

NUMBERS = np.ones(4)
Formula = Callable[[Any], Any]


def traced(formula: Formula) -> None:
    """Trace a formula of four numbers."""
    trace("formula", lambda x: {"y": formula(x)}, {"x": (4,)})


BRANCHES: dict[str, Formula] = {
    "if": lambda x: x if x[0] > 0.0 else -x,
    "if_any": lambda x: x if (x > 0.0).any() else -x,
    "not": lambda x: not x[0] > 0.0,
    "and": lambda x: x[0] > 0.0 and x[1] > 0.0,
    "chain": lambda x: 0.0 < x[0] < 1.0,
    "smallest": lambda x: min(x[0], x[1]),
    "membership": lambda x: x[0] in [1.0, 2.0],
    "whole_array": lambda x: bool(x),
    "assertion_on_numbers": lambda x: all(x > 0.0),
}


@pytest.mark.parametrize("name", BRANCHES)
def test_branches_on_unknown_numbers_are_refused(name: str) -> None:
    with pytest.raises(
        DataDependentBranchError, match=r"a branch on .*; write numpy\.where in its place"
    ) as refused:
        traced(BRANCHES[name])
    assert "SymbolicArray" in str(refused.value)


def test_branches_on_known_numbers_are_taken() -> None:
    def formula(x: Any) -> Any:
        zero = x * 0.0
        return x + 1.0 if (zero < 1.0).all() and not zero[0] else x

    function = trace("known", lambda x: {"y": formula(x)}, {"x": (2,)})
    np.testing.assert_array_equal(function.evaluate({"x": np.zeros(2)})["y"], np.ones(2))


KNOWN: dict[str, Formula] = {
    "float": lambda x: float(x[0] * 0.0 + 2.0),
    "float_of_one_element": lambda x: float((x * 0.0 + 2.0)[:1]),
    "function_of_math": lambda x: math.sqrt(x[0] * 0.0 + 4.0),
}


@pytest.mark.parametrize("name", KNOWN)
def test_known_numbers_are_converted(name: str) -> None:
    function = trace("known", lambda x: {"y": KNOWN[name](x) * x}, {"x": (4,)})
    np.testing.assert_array_equal(function.evaluate({"x": NUMBERS})["y"], 2.0 * NUMBERS)


FUNCTIONS: dict[str, Formula] = {
    "tan": np.tan,
    "hypot": lambda x: np.hypot(x, 1.0),
    "matmul": lambda x: x @ NUMBERS,
    "bitwise_xor": lambda x: (x > 0.0) ^ (x < 1.0),
    "divmod": lambda x: divmod(x, 2.0)[0],
    "floor_divide": lambda x: x // 2.0,
    "power": lambda x: x**3,
    "add.accumulate": lambda x: np.add.accumulate(x),
    "multiply.outer": lambda x: np.multiply.outer(x, x),
    "add.at": lambda x: np.add.at(x, [0], 1.0),
    "cumsum": np.cumsum,
    "einsum": lambda x: np.einsum("i,i->", x, NUMBERS),
    "dot": lambda x: np.dot(NUMBERS, x),
    "norm": np.linalg.norm,
    "sort": np.sort,
    "interp": lambda x: np.interp(x, NUMBERS, NUMBERS),
}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_unknown_functions_of_numpy_are_refused_by_name(name: str) -> None:
    with pytest.raises(UntraceableError, match="cannot be traced into compiled code") as refused:
        traced(FUNCTIONS[name])
    assert str(refused.value).startswith(f"numpy.{name} ")


POWERS: dict[str, Formula] = {
    "unknown_exponent": lambda x: x**x,
    "unknown_exponent_of_a_number": lambda x: 2.0**x,
    "several_exponents": lambda x: x ** np.array([2.0, 3.0, 2.0, 2.0]),
    "root": lambda x: x**0.5,
}


@pytest.mark.parametrize("name", POWERS)
def test_powers_other_than_squares_are_refused_by_their_name(name: str) -> None:
    with pytest.raises(UntraceableError) as refused:
        traced(POWERS[name])
    assert str(refused.value).startswith("numpy.power ")


def written(x: Any) -> Any:
    numbers = np.zeros(4)
    numbers[1:3] = x[1:3]
    return numbers


def added(x: Any) -> Any:
    numbers = np.zeros(4)
    numbers += x
    return numbers


CONVERSIONS: dict[str, Formula] = {
    "float": lambda x: float(x[0]),
    "int": lambda x: int(x[0]),
    "index": lambda x: operator.index(x[0]),
    "range": lambda x: range(x[0]),
    "round": lambda x: round(x[0]),
    "complex": lambda x: complex(x[0]),
    "index_of_a_list": lambda x: [1.0, 2.0][x[0]],
    "index_of_numbers": lambda x: NUMBERS[x[0]],
    "function_of_math": lambda x: math.sin(x[0]),
    "array": lambda x: np.asarray(x),
    "array_of_list": lambda x: np.array([x[0], x[1]]),
    "stack_of_lists": lambda x: np.stack([[x[0], 1.0], [2.0, x[1]]]),
    "written_into_numbers": written,
    "added_to_numbers": added,
    "out_of_numbers": lambda x: np.sin(x, out=np.zeros(4)),
}


@pytest.mark.parametrize("name", CONVERSIONS)
def test_conversions_to_numbers_are_refused(name: str) -> None:
    with pytest.raises(TypeError):  # Python's own, or `UntraceableError`, which is one
        traced(CONVERSIONS[name])


@pytest.mark.parametrize(
    "name", ["array", "array_of_list", "written_into_numbers", "added_to_numbers", "out_of_numbers"]
)
def test_conversions_to_arrays_say_that_numbers_are_unknown(name: str) -> None:
    with pytest.raises(UntraceableError, match="unknown numbers"):
        traced(CONVERSIONS[name])


@pytest.mark.parametrize("name", ["float", "function_of_math"])
def test_conversions_to_one_number_depend_on_data(name: str) -> None:
    with pytest.raises(
        DataDependentBranchError, match=r"the conversion of Sym.* to a number cannot be traced"
    ):
        traced(CONVERSIONS[name])


@pytest.mark.parametrize("kind", [np.int64, np.float16, np.complex128, "U3", object])
def test_conversions_to_other_kinds_of_numbers_are_refused(kind: Any) -> None:
    with pytest.raises(UntraceableError, match=f"the conversion to {re.escape(str(np.dtype(kind)))} cannot"):
        traced(lambda x: x.astype(kind))


def put_single(x: Any) -> Any:
    single = x.astype(np.float32)
    single[0] = x[1]
    return single


IN_SINGLE_PRECISION: dict[str, Formula] = {
    "sum_with_a_number": lambda x: x.astype(np.float32) + 1.0,
    "product_of_both_precisions": lambda x: x * x.astype(np.float32),
    "opposite": lambda x: -x.astype(np.float32),
    "comparison": lambda x: x.astype(np.float32) > 0.1,
    "sine": lambda x: np.sin(x[:2].astype(np.float32)),
    "sum": lambda x: x.astype(np.float32).sum(),
    "sum_by_numpy": lambda x: np.add.reduce(x.astype(np.float32)),
    "choice": lambda x: np.where(x > 0.0, x.astype(np.float32), np.float32(0.1)),
    "stack": lambda x: np.stack([x.astype(np.float32), x]),
    "assignment": put_single,
}


@pytest.mark.parametrize("name", IN_SINGLE_PRECISION)
def test_what_numpy_would_compute_in_single_precision_is_refused(name: str) -> None:
    with pytest.raises(UntraceableError, match="in single precision cannot be traced"):
        traced(IN_SINGLE_PRECISION[name])


def masked(x: Any) -> Any:
    x[x > 0.0] = 0.0
    return x


SELECTIONS: dict[str, Formula] = {
    "elements_where_unknown": lambda x: x[x > 0.0],
    "numbers_where_unknown": lambda x: x.reshape(2, 2)[x[:2] > 0.0],
    "assignment_where_unknown": masked,
    "two_unknown_indices": lambda x: x.reshape(2, 2)[np.floor(x), np.floor(x)],
    "unknown_index_after_a_slice": lambda x: x.reshape(2, 2)[:, np.floor(x)],
    "unknown_index_after_all_axes": lambda x: x.reshape(2, 2)[..., np.floor(x)],
    "unknown_index_after_a_new_axis": lambda x: x.reshape(2, 2)[None, np.floor(x)],
    "assignment_at_unknown_index": lambda x: x.__setitem__(np.floor(x[0]), 1.0),
}


@pytest.mark.parametrize("name", SELECTIONS)
def test_selections_that_would_need_numbers_are_refused(name: str) -> None:
    with pytest.raises(UntraceableError):
        traced(SELECTIONS[name])


OPTIONS: dict[str, Formula] = {
    "first_value": lambda x: np.add.reduce(x, initial=0.5),
    "some_elements": lambda x: np.add.reduce(x, where=NUMBERS < 2.0),
    "several_axes": lambda x: np.add.reduce(x.reshape(2, 2), axis=(0, 1)),
    "undefined_elements": lambda x: np.add(x, x, out=None, where=x > 0.0),
    "whole_numbers": lambda x: np.add(x, 0.5, dtype=np.int64, casting="unsafe"),
}


@pytest.mark.parametrize("name", OPTIONS)
def test_options_without_meaning_for_expressions_are_refused(name: str) -> None:
    with pytest.raises(UntraceableError):
        traced(OPTIONS[name])


def test_numbers_are_not_inverted() -> None:
    """As in NumPy; truth values are."""
    with pytest.raises(TypeError):
        traced(lambda x: ~x)
