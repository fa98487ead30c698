"""Every operation: the same bits from generated C code, from NumPy and from the evaluation of its node."""

import itertools
from functools import cache

import numpy as np
import pytest

from prp_gym.symbolic.array import SymbolicArray, elementwise
from prp_gym.symbolic.function import SymbolicFunction, trace
from prp_gym.symbolic.operations import COSINE, OPERATIONS, SINE, SINGLE, Operation
from tests.symbolic.compilation import Array, CompiledFunction, arity, compile_together

ROWS = 200
LARGEST, LEAST = np.finfo(np.float64).max, np.finfo(np.float64).tiny
HALVES = np.arange(-3.0, 3.5, 0.5)  # among them the edges of rounding
SPECIAL = np.array([*HALVES, -0.0, 1e-300, -1e300, np.pi, -np.pi / 2, 1e17, LARGEST, -LEAST, LEAST / 8])
SINGLE_RANGE = np.finfo(np.float32)
NOT_FINITE = (np.nan, np.inf, -np.inf, 0.0, 1.0, -1.0)
OF_THE_CPU = ("exp", "log", "power", "arctan2")
"""Functions whose last bit in NumPy depends on the kind of CPU; see `prp_gym.robot.arrays.elementwise`."""

EVERY_OPERATION = pytest.mark.parametrize("operation", OPERATIONS, ids=lambda operation: operation.name)


def arguments(operation: Operation) -> Array:
    """Finite arguments (rows, arity): of ordinary size, of every size, special, and equal to each other."""
    generator = np.random.default_rng(len(operation.name))
    shape = ROWS, arity(operation)
    ordinary = generator.normal(size=shape)
    wide = ordinary * 10.0 ** generator.integers(-300, 300, size=shape)
    special = generator.choice(SPECIAL, size=shape)
    equal = np.repeat(special[:, :1], shape[1], axis=1)
    return np.concatenate([ordinary, 100.0 * ordinary, wide, special, equal])


@cache
def traced(operation: Operation, of_truth_values: bool = False) -> SymbolicFunction:
    """One operation on inputs, or on whether they are negative."""

    def formula(**inputs: SymbolicArray) -> dict[str, SymbolicArray]:
        graph = next(iter(inputs.values())).graph
        arrays = [array < 0.0 if of_truth_values else array for array in inputs.values()]
        return {"result": SymbolicArray(graph, elementwise(graph, operation, *arrays))}

    names = [f"x{index}" for index in range(arity(operation))]
    kind = "truth_values" if of_truth_values else "numbers"
    return trace(f"{kind}_{operation.name}", formula, dict.fromkeys(names, ()))


@cache
def compiled() -> dict[str, CompiledFunction]:
    """All operations, of numbers and of truth values."""
    return compile_together(
        traced(each, of_truth_values) for each in OPERATIONS for of_truth_values in (False, True)
    )


def named(row: Array) -> dict[str, Array]:
    """A row of arguments by the names of the inputs."""
    return {f"x{index}": np.asarray(value) for index, value in enumerate(row)}


def of_numpy(operation: Operation, rows: Array) -> Array:
    """What the operation's function of NumPy returns for every row."""
    with np.errstate(all="ignore"):
        return np.array([operation.ufunc(*row) for row in rows], dtype=np.float64)


def evaluated(operation: Operation, rows: Array) -> Array:
    return np.array([operation.evaluate(*row) for row in rows.tolist()])


@EVERY_OPERATION
def test_compiled_code_gives_the_numbers_of_the_evaluation(operation: Operation) -> None:
    rows, code = arguments(operation), compiled()[f"numbers_{operation.name}"]
    found = np.array([code(named(row))["result"] for row in rows])
    np.testing.assert_array_equal(found, evaluated(operation, rows))


@EVERY_OPERATION
def test_evaluation_gives_the_numbers_of_numpy(operation: Operation) -> None:
    rows = arguments(operation)
    found, expected = evaluated(operation, rows), of_numpy(operation, rows)
    if operation.name in OF_THE_CPU:
        finite = np.isfinite(expected)
        np.testing.assert_array_equal(found[~finite], expected[~finite])
        np.testing.assert_array_max_ulp(found[finite], expected[finite], maxulp=4)
    else:
        np.testing.assert_array_equal(found, expected)


@EVERY_OPERATION
def test_what_is_not_a_number_is_passed_on_as_in_numpy(operation: Operation) -> None:
    """So that a controller that divides by zero is noticed, whatever limits its torques."""
    code = compiled()[f"numbers_{operation.name}"]
    rows = np.array(list(itertools.product(NOT_FINITE, repeat=arity(operation))))
    found = evaluated(operation, rows)
    np.testing.assert_array_equal(np.array([code(named(row))["result"] for row in rows]), found)
    maximum = 4 if operation.name in OF_THE_CPU else 0
    np.testing.assert_array_max_ulp(found, of_numpy(operation, rows), maxulp=maximum)


@EVERY_OPERATION
def test_evaluation_of_a_function_is_that_of_its_operation(operation: Operation) -> None:
    rows, function = arguments(operation), traced(operation)
    found = np.array([function.evaluate(named(row))["result"] for row in rows[::5]])
    np.testing.assert_array_equal(found, evaluated(operation, rows[::5]))


def test_rounding_to_single_precision_is_that_of_numpy() -> None:
    """For numbers of every size: ordinary, subnormal, to zero, to infinity, and halfway between two."""
    generator = np.random.default_rng(0)
    sizes = np.repeat(np.arange(-160, 135), 4)
    numbers = generator.choice([-1.0, 1.0], size=sizes.size) * np.ldexp(
        generator.uniform(1.0, 2.0, sizes.size), sizes
    )
    single = numbers[np.abs(numbers) < SINGLE_RANGE.max].astype(np.float32)
    halfway = (single.astype(np.float64) + np.nextafter(single, np.float32(np.inf))) / 2.0
    largest = np.ldexp(1.0 - 2.0**-25, 128)  # from which on numbers become infinite
    edges = [SINGLE_RANGE.max, np.nextafter(largest, 0.0), largest, SINGLE_RANGE.smallest_subnormal / 2.0]
    rows = np.concatenate([numbers, halfway, single, edges, np.negative(edges), [0.0, -0.0]])
    with np.errstate(over="ignore", under="ignore"):
        expected = rows.astype(np.float32).astype(np.float64)
    code = compiled()["numbers_single"]
    for found in (
        np.array([float(code({"x0": x})["result"]) for x in rows]),
        np.array([SINGLE.evaluate(x) for x in rows.tolist()]),
    ):
        np.testing.assert_array_equal(found, expected)
        np.testing.assert_array_equal(np.signbit(found), np.signbit(rows))
    rounded = np.abs(expected)
    subnormal = (rounded > 0.0) & (rounded < SINGLE_RANGE.smallest_normal)
    kinds = (expected != rows, np.isinf(rounded), rounded == 0.0, subnormal)
    assert [bool(kind.sum() > 10) for kind in kinds] == [True] * 4


def test_sine_and_cosine_of_one_angle_are_those_of_numpy() -> None:
    """A compiler may join them in one call of the mathematical library."""

    def both(x: SymbolicArray) -> dict[str, SymbolicArray]:
        sine, cosine = (elementwise(x.graph, operation, x) for operation in (SINE, COSINE))
        return {"sine": SymbolicArray(x.graph, sine), "cosine": SymbolicArray(x.graph, cosine)}

    code = compile_together([trace("both", both, {"x": ()})])["both"]
    generator = np.random.default_rng(0)
    for x in generator.normal(size=2000) * 10.0 ** generator.integers(-3, 5, size=2000):
        assert code({"x": x}) == {"sine": np.sin(x), "cosine": np.cos(x)}


@EVERY_OPERATION
def test_truth_values_count_as_one_and_zero(operation: Operation) -> None:
    """They are integers in C."""
    code, size = compiled()[f"truth_values_{operation.name}"], arity(operation)
    for bits in np.ndindex((2,) * size):
        values = [float(bit) for bit in bits]
        expected = operation.evaluate(*values)
        if np.isfinite(expected):
            assert code(named(-np.array(values)))["result"] == expected, values


def test_names_of_operations_are_unique() -> None:
    assert len({operation.name for operation in OPERATIONS}) == len(OPERATIONS)


@pytest.mark.parametrize(
    "operation", [one for one in OPERATIONS if one.commutes], ids=lambda operation: operation.name
)
def test_operations_that_commute_ignore_the_order(operation: Operation) -> None:
    rows = arguments(operation)
    np.testing.assert_array_equal(evaluated(operation, rows), evaluated(operation, rows[:, ::-1]))


@EVERY_OPERATION
def test_truth_values_are_what_is_declared_as_such(operation: Operation) -> None:
    found = set(evaluated(operation, arguments(operation)).tolist())
    assert operation.boolean == (found <= {0.0, 1.0})
