"""Sums in order: the same bits for one row and for many, for every memory layout, and as Python's numbers."""

import math

import numpy as np
import pytest

from prp_gym.robot.arrays import (
    apply,
    apply_transposed,
    dot,
    elementwise,
    multiply,
    norm,
    pseudoinverse_transposed,
    solve_least_squares,
    solve_symmetric,
    total,
)

ROWS = 50
RNG = np.random.default_rng(1)
MATRICES, VECTORS = RNG.normal(size=(ROWS, 6, 3)), RNG.normal(size=(ROWS, 3))
TALL = RNG.normal(size=(ROWS, 6))
ROUNDING = 1e-11  # a few roundings, times the square of the condition number of a random 6 x 3 matrix


def in_order(values: list[float]) -> float:
    """The sum of Python's numbers from the first to the last."""
    result = values[0]
    for value in values[1:]:
        result += value
    return result


@pytest.mark.parametrize("size", [1, 2, 3, 8, 12, 40])
def test_totals_add_the_components_one_after_the_other(size: int) -> None:
    values = RNG.normal(size=(ROWS, size)) * 10.0 ** RNG.integers(-8, 8, size=(ROWS, size))
    expected = [in_order(row) for row in values.tolist()]
    for layout in (values, np.asfortranarray(values), np.repeat(values, 2, axis=0)[::2]):
        np.testing.assert_array_equal(total(layout), expected)
    np.testing.assert_array_equal([total(row[None])[0] for row in values], expected)


@pytest.mark.parametrize("columns", [3, 6, 12])
def test_products_of_one_row_are_those_of_many(columns: int) -> None:
    matrices, vectors = RNG.normal(size=(ROWS, 6, columns)), RNG.normal(size=(ROWS, columns))
    together = apply(matrices, vectors)
    for index in range(ROWS):
        one = np.s_[index : index + 1]
        np.testing.assert_array_equal(apply(matrices[one], vectors[one])[0], together[index])
        np.testing.assert_array_equal(apply(matrices[index], vectors[index]), together[index])
    np.testing.assert_array_equal(apply_transposed(matrices.mT, vectors), together)
    np.testing.assert_allclose(together, np.einsum("nij,nj->ni", matrices, vectors), atol=1e-13)


def test_norms_and_solutions_of_one_row_are_those_of_many() -> None:
    lengths, solutions = norm(VECTORS), solve_least_squares(MATRICES, TALL, 0.1)
    for index in range(ROWS):
        one = np.s_[index : index + 1]
        assert norm(VECTORS[one])[0] == lengths[index]
        np.testing.assert_array_equal(solve_least_squares(MATRICES[one], TALL[one], 0.1)[0], solutions[index])
    np.testing.assert_array_equal(norm(VECTORS[:6].reshape(2, 3, 3)), lengths[:6].reshape(2, 3))
    np.testing.assert_allclose(lengths, np.linalg.norm(VECTORS, axis=-1), rtol=1e-15)
    np.testing.assert_allclose(dot(VECTORS, VECTORS), lengths**2, rtol=1e-15)


@pytest.mark.parametrize("damping", [0.0, 0.3])
def test_solutions_are_those_of_lapack(damping: float) -> None:
    normal = MATRICES.mT @ MATRICES + damping**2 * np.eye(3)
    expected = np.linalg.solve(normal, (MATRICES.mT @ TALL[..., None]))[..., 0]
    np.testing.assert_allclose(solve_least_squares(MATRICES, TALL, damping), expected, rtol=ROUNDING)
    solved = solve_symmetric(normal, VECTORS)
    np.testing.assert_allclose(solved, np.linalg.solve(normal, VECTORS[..., None])[..., 0], rtol=ROUNDING)


def test_pseudoinverse_and_products_of_matrices_are_those_of_lapack_and_blas() -> None:
    inverse = np.linalg.pinv(MATRICES).astype(np.float64)
    np.testing.assert_allclose(pseudoinverse_transposed(MATRICES), inverse.mT, atol=ROUNDING)
    np.testing.assert_allclose(multiply(inverse, MATRICES), inverse @ MATRICES, atol=1e-13)


def test_elementwise_applies_a_function_of_numbers() -> None:
    found = elementwise(math.atan2, VECTORS, VECTORS[::-1])
    assert found.shape == VECTORS.shape
    assert found[3, 1] == math.atan2(VECTORS[3, 1], VECTORS[-4, 1])
