"""Nested tuples of arrays as rows of numbers: there and back, and what is refused."""

from typing import Any, NamedTuple

import numpy as np
import pytest

from prp_gym.errors import UntraceableError
from prp_gym.symbolic.array import SymbolicArray
from prp_gym.symbolic.graph import Graph
from prp_gym.symbolic.nested_rows import NestedRows

N = 4


class Filter(NamedTuple):
    """Something that a mode may keep."""

    value: Any
    started: Any


def nested() -> Any:
    rng = np.random.default_rng(0)
    single = rng.normal(size=N).astype(np.float32)
    return (rng.normal(size=(N, 2, 3)), None, Filter(single, rng.normal(size=(N, 2)) > 0.0), ())


def assert_equal(found: Any, expected: Any) -> None:
    assert type(found) is type(expected)
    if isinstance(expected, tuple):
        assert len(found) == len(expected)
        for one, other in zip(found, expected, strict=True):
            assert_equal(one, other)
    elif expected is not None:
        assert found.dtype == expected.dtype
        np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize("values", [nested(), None, (), np.arange(4.0), (None, (np.ones((N, 0)),))])
def test_values_are_read_and_written_with_their_types(values: Any) -> None:
    rows = NestedRows(values, N)
    numbers = rows.read(values, N)
    assert numbers.shape == (N, rows.size)
    assert numbers.dtype == np.float64
    assert_equal(rows.write(numbers), values)
    assert rows.fit(values, N)


def test_written_values_are_new_arrays() -> None:
    values = nested()
    rows = NestedRows(values, N)
    numbers = rows.read(values, N)
    rows.write(numbers)[0][:] = 7.0
    np.testing.assert_array_equal(numbers, rows.read(values, N))


@pytest.mark.parametrize(
    "other",
    [
        None,
        (np.ones(N),),
        (np.ones((N, 2)), None),
        (np.ones((N, 3)), np.ones(N)),
        (np.ones((N, 2), dtype=np.float32), np.ones(N)),
        [np.ones((N, 2)), np.ones(N)],
        Filter(np.ones((N, 2)), np.ones(N)),
    ],
)
def test_values_of_another_structure_do_not_fit(other: Any) -> None:
    assert not NestedRows((np.ones((N, 2)), np.ones(N)), N).fit(other, N)


@pytest.mark.parametrize(
    "wrong",
    [
        {"a": np.ones(N)},
        [np.ones(N)],
        (1.0,),
        np.ones(N, dtype=np.int64),
        np.ones(N + 1),
        np.array(1.0),
        (np.array(["a"] * N),),
    ],
)
def test_values_of_another_kind_are_refused(wrong: Any) -> None:
    with pytest.raises(UntraceableError, match="memory"):
        NestedRows(wrong, N)


def symbols(*shape: int) -> SymbolicArray:
    return SymbolicArray.inputs(Graph(), "x", shape)


def test_symbolic_rows_become_values_and_rows_again() -> None:
    rows = NestedRows(nested(), N)
    given = symbols(1, rows.size)
    values = rows.write(given)
    assert values[0].shape == (1, 2, 3)
    assert values[2].started.map(lambda node: node).flat()[0].is_boolean
    assert rows.read(values, 1).shape == (1, rows.size)


@pytest.mark.parametrize(
    "changed",
    [
        lambda values: None,
        lambda values: values[:1],
        lambda values: (values[0], values[1], None),
        lambda values: (values[0], values[1], values[2].astype(np.float64)),
        lambda values: (values[0][:, :1], values[1], values[2]),
        lambda values: (values[0], np.zeros(1), values[2]),
        lambda values: (np.zeros((1, 2), dtype=np.bool_), values[1], values[2]),
    ],
)
def test_symbolic_values_whose_structure_changes_are_refused(changed: Any) -> None:
    rows = NestedRows((np.ones((N, 2)), None, np.ones(N, dtype=np.float32)), N)
    values = rows.write(symbols(1, rows.size))
    assert rows.read(values, 1).shape == (1, 3)
    with pytest.raises(UntraceableError, match="change"):
        rows.read(changed(values), 1)
