"""Symbolic arrays: what NumPy's functions give for numbers, traced formulas give too."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from prp_gym.symbolic.function import trace
from prp_gym.symbolic.operations import OPERATIONS, Operation
from tests.symbolic.compilation import Array

FEW = settings(max_examples=25)
ROUNDING = 1e-15  # a few units in the last digit, in which some functions of NumPy depend on the CPU
ROWS = np.array([0, 1, 2])
MASK = np.array([True, False, True])
TABLE = np.arange(12.0).reshape(3, 4) ** 2


def quarters(shape: tuple[int, ...], seed: int = 0) -> Array:
    """Random multiples of ¼, zero among them, whose sums and products are exact in any order."""
    return np.random.default_rng(seed).integers(-8, 9, size=shape) / 4.0


def assert_traced_as_computed(formula: Callable[..., Any], *values: Array, rtol: float = 0.0) -> None:
    """A formula that may write into its arguments gives the same array, traced and of numbers."""

    def on_copies(**inputs: Any) -> dict[str, Any]:
        return {"result": formula(*(array.copy() for array in inputs.values()))}

    shapes = {f"x{index}": value.shape for index, value in enumerate(values)}
    with np.errstate(all="ignore"):
        expected = np.asarray(formula(*(value.copy() for value in values)))
    found = trace("formula", on_copies, shapes).evaluate(dict(zip(shapes, values, strict=True)))["result"]
    assert found.shape == expected.shape
    np.testing.assert_allclose(found, expected, rtol=rtol, atol=0.0)


def then(*changes: Callable[[Any, Any], Any]) -> Callable[[Any, Any], Any]:
    """A formula of x and y that returns x after some changes of it."""

    def formula(x: Any, y: Any) -> Any:
        for change in changes:
            change(x, y)
        return x

    return formula


def put(key: Any, value: Callable[[Any, Any], Any]) -> Callable[[Any, Any], Any]:
    """The assignment x[key] = value."""
    return lambda x, y: x.__setitem__(key, value(x, y))


def index_of(values: Any, most: int) -> Any:
    """Numbers as indices from 0 to `most`."""
    whole = np.clip(np.floor(np.abs(2.0 * values)), 0.0, float(most))
    return whole.astype(np.intp) if isinstance(whole, np.ndarray) else whole


def in_place(x: Any, y: Any) -> Any:
    x += y
    x -= 0.5
    x[0] *= y[1]
    x[..., 1] /= 2.0
    x %= 1.5
    return x


def into_views(x: Any, y: Any) -> Any:
    row = x[1]
    row[:] = y[0]
    row[..., 2] = -row[..., 0]
    first = x[..., 0]
    first[1:] = 7.0
    x.mT[2, :2] = y[2, :2]
    x.reshape(-1)[4:6] = y[1, :2]
    return x


FORMULAS: dict[str, Callable[[Any, Any], Any]] = {
    "rows_and_columns": lambda x, y: x[1] * y[:, 2] - x[-1, ::-1] + x[..., 0],
    "new_axes": lambda x, y: x[:, None, 1:] * y[None, ..., 1:],
    "lists_and_arrays_as_indices": lambda x, y: x[[2, 0]] + y[ROWS, [1, 1, 0]][:2, None],
    "known_masks": lambda x, y: x[MASK] + y[~MASK],
    "assign_rows": then(put(1, lambda x, y: y[0]), put(np.s_[:, 1], lambda x, y: x[:, 2])),
    "assign_masked": then(put(MASK, lambda x, y: y[MASK] * 2.0), put(~MASK, lambda x, y: 0.0)),
    "assign_at_indices": then(put((ROWS, [2, 1, 0]), lambda x, y: y[..., 0])),
    "assign_an_overlapping_part": then(put(np.s_[1:], lambda x, y: x[:-1]), put(..., lambda x, y: x[::-1])),
    "assign_one_number": then(put((0, 1), lambda x, y: 5.0)),
    "assign_one_element": then(put((-1, 2), lambda x, y: y[0, 0] * x[1, 1])),
    "in_place_operators": in_place,
    "views": into_views,
    "comparisons": lambda x, y: (x < y) | (x > 1.0) & ~(x == y) | (x >= -y) & (y != 0.0) | (x <= -2.0),
    "where": lambda x, y: np.where((x > y) & (y < 1.0), x, -1.0) + np.where(MASK, x, y[0]),
    "where_of_numbers": lambda x, y: np.where(x, 1.0, y),
    "clip": lambda x, y: np.clip(x, -0.5, y) + np.clip(x, y, 0.25),
    "clip_without_bound": lambda x, y: np.clip(x, None, 0.5) + np.clip(y, -0.5, None),
    "powers": lambda x, y: x**2 + np.square(y) - np.power(x, 2.0),
    "stack": lambda x, y: np.stack([x, y, np.ones((3, 3))], axis=-1),
    "concatenate": lambda x, y: np.concatenate([x, y[:1], TABLE[:, :3]]),
    "concatenate_columns": lambda x, y: np.concatenate((x, y[:, :2]), axis=-1),
    "rearranged": lambda x, y: np.swapaxes(x, 0, 1) + np.moveaxis(y, 0, -1) + x.mT + np.copy(y),
    "transposed": lambda x, y: np.transpose(x, (1, 0)) - y,
    "diagonal": lambda x, y: np.diagonal(x) * np.diagonal(y, axis1=-2, axis2=-1),
    "reshaped": lambda x, y: x.reshape(-1) + np.reshape(y, 9) + np.expand_dims(x, 0).reshape(9),
    "broadcast": lambda x, y: np.broadcast_to(x[0], (3, 3)) + np.broadcast_arrays(y[:, :1], x)[0],
    "like": lambda x, y: np.zeros_like(x) + np.zeros_like(y, shape=(3,)) + x,
    "rows_in_turn": lambda x, y: np.stack([row * 2.0 for row in x]) + y[len(x) - 1],
    "sums": lambda x, y: x.sum() + y.sum(axis=0) + x.sum(axis=-1, keepdims=True) + np.add.reduce(y, axis=1),
    "sum_of_everything_kept": lambda x, y: x.sum(keepdims=True) + y,
    "largest": lambda x, y: x.max(axis=1) + y.max() - np.minimum.reduce(x) + x.max(axis=0, keepdims=True),
    "number_of_truth_values": lambda x, y: (
        (x > y).sum(axis=-1) + np.add.reduce(x < y) + (x > 0.0).sum() / 2.0
    ),
    "any_and_all": lambda x, y: (x > y).any(axis=0) & (x > -3.0).all() | np.logical_and.reduce(x > 1.0),
    "any_number": lambda x, y: x[:1].any(axis=0) * 2.0 + y[:, :1].all(axis=-1),
    "sum_of_constants": lambda x, y: np.zeros_like(x) + 0.5 + np.zeros_like(y) + x * 0.0,
    "sum_of_truth_values": lambda x, y: (x > 0.0) + (y > 0.0),
    "arithmetic_of_truth_values": lambda x, y: 2.0 * (x > 0.0) - y * (y < 0.0),
    "numbers_of_truth_values": lambda x, y: (
        (x > y).astype(np.float64) + (y > 0.0).astype(float) + x.astype(float)
    ),
    "truth_values_of_numbers": lambda x, y: x.astype(np.bool_) & (y > 0.0) | y.astype(bool).astype(bool),
    "numbers_that_differ_from_zero": lambda x, y: (
        np.count_nonzero(x, axis=1) - np.count_nonzero(y > 0.5, axis=0) + np.count_nonzero(x * y) / 2.0
    ),
    "single_precision": lambda x, y: (x / 3.0).astype(np.float32).astype(np.float64) - y / 3.0,
    "single_precision_of_truth_values": lambda x, y: (x > y).astype(np.float32),
    "parts_in_single_precision": lambda x, y: (
        (x / 3.0).astype(np.float32)[1:, ::-1].mT.copy().reshape(-1).astype(np.float32).astype(np.float64)
    ),
    "largest_in_single_precision": lambda x, y: (x / 3.0).astype(np.float32).max(axis=0).astype(float),
    "assign_single_precision": then(put(1, lambda x, y: (y[0] / 3.0).astype(np.float32))),
    "quotient_where": lambda x, y: np.divide(x, y, out=np.zeros_like(x), where=y != 0.0),
    "out": lambda x, y: np.multiply(x, y[0], out=y) + y,
}


@pytest.mark.parametrize("name", FORMULAS)
def test_traced_formulas_give_the_arrays_of_numpy(name: str) -> None:
    for seed in range(3):
        assert_traced_as_computed(FORMULAS[name], quarters((3, 3), seed), quarters((3, 3), seed + 10))


INDEXED: dict[str, Callable[[Any, Any], Any]] = {
    "alone": lambda values, index: values[index],
    "after_rows": lambda values, index: values[ROWS, index],
    "next_ones": lambda values, index: values[ROWS, index + 1],
    "before_a_slice": lambda values, index: values[index, 1:],
    "after_a_number": lambda values, index: values[1, index],
    "after_rows_of_another_shape": lambda values, index: values[np.array([[0], [2]]), index],
    "from_the_end": lambda values, index: values[-index],
    "single": lambda values, index: values[index[1]],
}


@pytest.mark.parametrize("name", INDEXED)
def test_elements_at_unknown_indices_are_those_of_numpy(name: str) -> None:
    def formula(values: Any, numbers: Any) -> Any:
        return INDEXED[name](values, index_of(numbers, 2))

    for seed in range(5):
        assert_traced_as_computed(formula, quarters((3, 4, 2), seed), quarters((3,), seed + 10))


@pytest.mark.parametrize("operation", OPERATIONS, ids=lambda operation: operation.name)
def test_every_operation_broadcasts_and_takes_numbers(operation: Operation) -> None:
    ufunc: Any = operation.ufunc
    if not isinstance(ufunc, np.ufunc):
        pytest.skip("not a ufunc; a test above has numpy.where")
    x, y = np.array([[0.5], [-1.5], [2.5]]), np.array([1.5, -0.5, 2.0, 3.5])
    if ufunc.nin == 1:
        assert_traced_as_computed(lambda x: np.square(ufunc(np.abs(x))), x[:, :1], rtol=ROUNDING)
    else:
        for formula in (ufunc, lambda x, y: ufunc(x, 1.5), lambda x, y: ufunc(TABLE, y)):
            assert_traced_as_computed(formula, x, y, rtol=ROUNDING)


@FEW
@given(data=st.data())
def test_shapes_broadcast_as_those_of_numpy(data: st.DataObject) -> None:
    shapes = data.draw(
        arrays.mutually_broadcastable_shapes(num_shapes=2, max_dims=3, max_side=3)
    ).input_shapes
    assert_traced_as_computed(lambda x, y: x * y - 1.0, *map(quarters, shapes))


@FEW
@given(data=st.data())
def test_parts_are_read_and_written_as_those_of_numpy(data: st.DataObject) -> None:
    shape = data.draw(arrays.array_shapes(max_dims=3, max_side=3))
    key = data.draw(arrays.basic_indices(shape, allow_newaxis=True) | arrays.integer_array_indices(shape))

    def rewritten(x: Any, y: Any) -> Any:
        x[key] = 2.0 * y[key]
        return x

    assert_traced_as_computed(lambda x: x[key] * 2.0, quarters(shape))
    assert_traced_as_computed(rewritten, quarters(shape), quarters(shape, 1))


def test_copies_share_no_element_and_views_all() -> None:
    def formula(x: Any) -> dict[str, Any]:
        x = x.copy()  # an argument is no array of the formula's own
        kept, view = x.copy(), x[1:]
        view[:] = 0.0
        return {"kept": kept, "x": x + 0.0, "copied": np.copy(kept[1:])}

    found = trace("formula", formula, {"x": (3,)}).evaluate({"x": np.ones(3)})
    np.testing.assert_array_equal(found["kept"], np.ones(3))
    np.testing.assert_array_equal(found["x"], [1.0, 0.0, 0.0])
    np.testing.assert_array_equal(found["copied"], np.ones(2))


def test_arguments_that_a_formula_overwrites_stay_its_inputs() -> None:
    def formula(x: Any) -> dict[str, Any]:
        x[...] = x[::-1]
        return {"reversed": x}

    function = trace("formula", formula, {"x": (3,)})
    assert [node.name for node in function.inputs["x"].flat()] == ["x[0]", "x[1]", "x[2]"]
    x = np.array([1.0, 2.0, 3.0])
    np.testing.assert_array_equal(function.evaluate({"x": x})["reversed"], x[::-1])
