"""A formula over rows gives the bits of NumPy, whether it is compiled or not."""

import copy
import pickle
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

from prp_gym.symbolic import elementary_functions, row_function
from prp_gym.symbolic.row_function import RowFunction
from tests.support.compiler import needs_compiler

SHAPES: dict[str, tuple[int, ...]] = {"vector": (3,), "matrix": (2, 3), "number": ()}


def mixed(vector: Any, matrix: Any, number: Any) -> Mapping[str, Any]:
    product = (matrix * vector[:, None, :]).sum(axis=-1)
    return {
        "product": product + np.sin(number)[:, None],
        "length": np.sqrt((vector * vector).sum(axis=-1)),
        "scaled": matrix / (1.0 + number * number)[:, None, None],
    }


def nothing(number: Any) -> Mapping[str, Any]:
    return {"nothing": -0.0 * number}


def branching(number: Any) -> Mapping[str, Any]:
    return {"sign": number if number[0] > 0.0 else -number}


def arguments(count: int) -> dict[str, Any]:
    rng = np.random.default_rng(count)
    return {name: rng.normal(size=(count, *shape)) for name, shape in SHAPES.items()}


def assert_bits(found: Mapping[str, Any], expected: Mapping[str, Any]) -> None:
    assert list(found) == list(expected)
    for name, values in expected.items():
        assert found[name].shape == values.shape, name
        assert found[name].tobytes() == values.tobytes(), name


@needs_compiler
def test_compiled_rows_have_the_bits_of_numpy() -> None:
    function = RowFunction("prp_mixed", mixed, SHAPES)
    for count in (1, 3, 1, 7, 7):
        given = arguments(count)
        assert_bits(function(**given), mixed(**given))
    assert function.is_compiled


@needs_compiler
def test_results_of_a_call_stay_as_they_are() -> None:
    function = RowFunction("prp_mixed", mixed, SHAPES)
    first = function(**arguments(2))
    kept = {name: values.copy() for name, values in first.items()}
    function(**{name: values + 1.0 for name, values in arguments(2).items()})
    assert_bits(first, kept)


@needs_compiler
def test_a_row_that_stands_for_all_is_repeated() -> None:
    function, given = RowFunction("prp_mixed", mixed, SHAPES), arguments(4)
    repeated = {**given, "matrix": np.tile(given["matrix"][:1], (4, 1, 1))}
    assert_bits(function(**{**given, "matrix": given["matrix"][0]}), mixed(**repeated))


@pytest.mark.parametrize("turned_off", [False, True])
def test_zeros_are_positive(turned_off: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    if turned_off:
        monkeypatch.setenv("PRP_GYM_COMPILED", "0")
    found = RowFunction("prp_nothing", nothing, {"number": ()})(number=np.array([1.0, -2.0]))
    assert not np.signbit(found["nothing"]).any()


def test_formula_that_branches_is_left_to_numpy() -> None:
    function = RowFunction("prp_branching", branching, {"number": ()})
    np.testing.assert_array_equal(function(number=np.array([-3.0]))["sign"], [3.0])
    assert not function.is_compiled


def test_functions_that_machines_round_differently_are_left_to_numpy(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(elementary_functions, "elementary_functions_agree", lambda: False)
    function, given = RowFunction("prp_mixed", mixed, SHAPES), arguments(2)
    assert_bits(function(**given), mixed(**given))
    assert not function.is_compiled


def test_without_compiled_code_numpy_computes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(row_function, "compiles_by_default", lambda: False)
    function, given = RowFunction("prp_mixed", mixed, SHAPES), arguments(2)
    assert_bits(function(**given), mixed(**given))
    assert not function.is_compiled


@needs_compiler
@pytest.mark.parametrize("copied", [copy.deepcopy, lambda function: pickle.loads(pickle.dumps(function))])
def test_copies_compute_on_their_own(copied: Any) -> None:
    function, given = RowFunction("prp_mixed", mixed, SHAPES), arguments(2)
    first = function(**given)
    other = copied(function)
    assert_bits(other(**given), first)
    other(**{name: values + 1.0 for name, values in given.items()})
    assert_bits(function(**given), first)
