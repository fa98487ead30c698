"""Conversion and shape checks of joint vectors and tip positions, and products over leading dimensions.

Sums over components are written out in their order: their rounding depends neither on the CPU nor on a
library for linear algebra, nor on the memory layout, nor on the number of rows.
"""

import math
from collections.abc import Callable
from functools import reduce
from operator import add, mul
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from prp_gym.checks import Array, as_array, check_finite
from prp_gym.errors import InvalidValueError, ShapeError
from prp_gym.symbolic.array import is_symbolic

__all__ = [
    "Array",
    "anywhere",
    "apply",
    "apply_transposed",
    "as_vectors",
    "broadcast",
    "dot",
    "matrix_like",
    "multiply",
    "norm",
    "pseudoinverse_transposed",
    "solve_least_squares",
    "solve_symmetric",
    "sum_of_products",
    "total",
    "zeros",
]

_INVERTIBLE = "one that can be inverted"
_OF_ARRAYS: dict[Callable[..., float], np.ufunc] = {
    math.atan2: np.arctan2,
    math.exp: np.exp,
    math.log: np.log,
    math.pow: np.float_power,
}
_LOWER = ((0, 0), (1, 0), (2, 0), (1, 1), (2, 1), (2, 2))


def as_vectors(values: ArrayLike, what: str, size: int = 3) -> Array:
    """`values` as a float64 array whose last axis has `size` finite components.

    Raises:
        ShapeError: the last axis has another size.
        InvalidValueError: values that are not numbers, or are so large that products of them overflow.
        NonFiniteError: NaN or infinity.
    """
    array = as_array(what, values)
    if array.ndim == 0 or array.shape[-1] != size:
        raise ShapeError(what, array.shape, f"(..., {size})")
    check_finite(what, array)
    return array


def broadcast(*arrays: Array) -> tuple[Array, ...]:
    """The arrays with common leading dimensions.

    Raises:
        InvalidValueError: arrays without common leading dimensions.
    """
    if all(array.shape == arrays[0].shape for array in arrays):
        return arrays
    try:
        return tuple(np.broadcast_arrays(*arrays))
    except ValueError:
        shapes = ", ".join(str(array.shape) for array in arrays)
        raise InvalidValueError("leading dimensions", shapes, "dimensions that broadcast") from None


def matrix_like(reference: Array, rows: int, columns: int) -> Array:
    """Zeros (..., rows, columns) with the leading dimensions of `reference`."""
    return zeros((*reference.shape[:-1], rows, columns), reference)


def zeros(shape: tuple[int, ...], reference: Array) -> Array:
    """Zeros that values of the kind of `reference` can be written into: of symbolic arrays, symbolic ones."""
    if is_symbolic(reference):
        symbolic: Any = reference
        return np.zeros_like(symbolic, shape=shape)
    return np.zeros(shape)


def anywhere(mask: NDArray[np.bool_]) -> bool:
    """Whether a mask is true somewhere, for a shortcut that gives the same result as the whole formula.

    While a formula is traced this is not known, and no shortcut is taken.
    """
    return is_symbolic(mask) or bool(np.count_nonzero(mask))


def elementwise(function: Callable[..., float], *values: Array) -> Array:
    """A function of the module `math` for every element of arrays of one shape.

    NumPy's own `exp`, `log`, `arctan2` and powers differ in the last bit between kinds of CPU; its `sin`,
    `cos` and `sqrt` do not.
    """
    if any(map(is_symbolic, values)):
        traced: Array = _OF_ARRAYS[function](*values)
        return traced
    results = map(function, *(array.ravel().tolist() for array in values))
    return np.array(list(results)).reshape(values[0].shape)


def total(values: Array) -> Array:
    """Sum over the last axis in the order of its components: (..., n) -> (...).

    Unlike the sums of NumPy and of BLAS, its rounding depends neither on the memory layout nor on the CPU.
    """
    if values.ndim == 2 and len(values) == 1 and type(values) is np.ndarray:
        return np.array([reduce(add, row) for row in values.tolist()])
    result: Array = values[..., 0]
    for index in range(1, values.shape[-1]):
        result = result + values[..., index]
    return result


def dot(left: Array, right: Array) -> Array:
    """Scalar product over the last axis, summed in order: (..., n), (..., n) -> (...)."""
    if left.shape == right.shape and left.size == left.shape[-1] and _are_numbers(left, right):
        product = sum_of_products(left.ravel().tolist(), right.ravel().tolist())
        return np.array(product, ndmin=left.ndim - 1)
    return total(left * right)


def sum_of_products(left: list[float], right: list[float]) -> float:
    """Scalar product of numbers, summed in order."""
    if len(left) == 3:
        a, b, c = left
        x, y, z = right
        return a * x + b * y + c * z
    return float(reduce(add, map(mul, left, right)))


def norm(vector: Array) -> Array:
    """Euclidean norm over the last axis, summed in order: (..., n) -> (...)."""
    if vector.size == vector.shape[-1] and type(vector) is np.ndarray:
        numbers = vector.ravel().tolist()
        return np.array(math.sqrt(sum_of_products(numbers, numbers)), ndmin=vector.ndim - 1)
    length: Array = np.sqrt(total(vector * vector))
    return length


def multiply(left: Array, right: Array) -> Array:
    """Product of two matrices, summed in order: (..., m, k), (..., k, n) -> (..., m, n)."""
    product: Array = left[..., :, :1] * right[..., :1, :]
    for index in range(1, left.shape[-1]):
        product = product + left[..., :, index : index + 1] * right[..., index : index + 1, :]
    return product


def apply(matrix: Array, vector: Array) -> Array:
    """Matrix times vector over leading dimensions, summed in order: (..., m, n), (..., n) -> (..., m)."""
    if _is_single(matrix, vector):
        components, rows = vector.ravel().tolist(), _rows(matrix)
        if len(components) == 3:
            x, y, z = components
            product = [a * x + b * y + c * z for a, b, c in rows]
        else:
            product = [reduce(add, map(mul, row, components)) for row in rows]
        return np.array(product).reshape(matrix.shape[:-1])
    return total(matrix * vector[..., None, :])


def apply_transposed(matrix: Array, vector: Array) -> Array:
    """Transposed matrix times vector, summed in order: (..., m, n), (..., m) -> (..., n)."""
    return apply(matrix.mT, vector)


def solve_symmetric(matrix: Array, vector: Array) -> Array:
    """Solution of a symmetric, positive definite system, A⁻¹b: (..., 3, 3), (..., 3) -> (..., 3).

    Args:
        matrix: A (..., 3, 3); its lower triangle is read.
        vector: b (..., 3).

    Raises:
        InvalidValueError: a matrix that is singular.
    """
    lower = (matrix[..., i, j] for i, j in _LOWER)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        solution = np.stack(_solve_components(*lower, *(vector[..., i] for i in range(3))), axis=-1)
    if type(solution) is np.ndarray and not np.isfinite(solution).all():
        raise InvalidValueError("matrix", matrix, _INVERTIBLE)
    return solution


def solve_least_squares(matrix: Array, vector: Array, damping: float = 0.0) -> Array:
    """Damped pseudoinverse times vector, (AᵀA + λ²I)⁻¹Aᵀb: (..., m, 3), (..., m) -> (..., 3).

    Args:
        matrix: A (..., m, 3) with m >= 3; it must have full column rank if the damping is zero.
        vector: b (..., m).
        damping: λ, in the units of A's singular values.

    Raises:
        InvalidValueError: a matrix without full column rank, and no damping.

    Source: [S] 3.5.
    """
    if _is_single(matrix, vector):
        numbers = _normal_numbers(_rows(matrix), vector.ravel().tolist(), damping * damping)
        try:
            solution = _solve_components(*numbers)
            return np.array(solution).reshape(*vector.shape[:-1], 3)
        except ZeroDivisionError:
            raise InvalidValueError("matrix", matrix, _INVERTIBLE) from None
    right = vector[..., None]
    normal = matrix[..., 0, :, None] * matrix[..., 0, None, :]
    projected = matrix[..., 0, :] * right[..., 0, :]
    for row in range(1, matrix.shape[-2]):
        normal = normal + matrix[..., row, :, None] * matrix[..., row, None, :]
        projected = projected + matrix[..., row, :] * right[..., row, :]
    return solve_symmetric(normal + damping * damping * np.eye(3), projected)


def pseudoinverse_transposed(matrix: Array) -> Array:
    """A(AᵀA)⁻¹, the transpose of the pseudoinverse, of full column rank: (..., m, 3) -> (..., m, 3).

    Source: [S] 3.5.
    """
    normal = multiply(np.swapaxes(matrix, -1, -2), matrix)
    return solve_symmetric(normal[..., None, :, :], matrix)


def _is_single(matrix: Array, vector: Array) -> bool:
    """Whether there is one matrix and one vector; its numbers are faster than arrays, with the same bits."""
    count = vector.size * matrix.size
    rows, columns = matrix.shape[-2:]
    single = count == rows * columns * vector.shape[-1] and matrix.ndim == vector.ndim + 1
    return single and _are_numbers(matrix, vector)


def _are_numbers(left: Array, right: Array) -> bool:
    """Whether neither array is symbolic."""
    return type(left) is np.ndarray and type(right) is np.ndarray


def _rows(matrix: Array) -> list[list[float]]:
    """The rows of one matrix, whatever its leading dimensions."""
    rows: Any = matrix.reshape(matrix.shape[-2:]).tolist()
    return list(rows)


def _normal_numbers(rows: list[list[float]], right: list[float], square: float) -> list[float]:
    """The lower triangle of AᵀA + λ²I, then Aᵀb."""
    columns = list(zip(*rows, strict=True))
    lower = [reduce(add, map(mul, columns[i], columns[j])) + (square if i == j else 0.0) for i, j in _LOWER]
    return lower + [reduce(add, map(mul, column, right)) for column in columns]


def _solve_components(
    a_11: Any, a_21: Any, a_31: Any, a_22: Any, a_32: Any, a_33: Any, b_1: Any, b_2: Any, b_3: Any
) -> tuple[Any, Any, Any]:
    """A⁻¹b by the factors LDLᵀ of A, of numbers or of arrays.

    Source: Golub 2013, 4.1.
    """
    l_21, l_31 = a_21 / a_11, a_31 / a_11
    d_2, rest = a_22 - l_21 * a_21, a_32 - l_31 * a_21
    l_32 = rest / d_2
    d_3 = a_33 - l_31 * a_31 - l_32 * rest
    y_2 = b_2 - l_21 * b_1
    y_3 = b_3 - l_31 * b_1 - l_32 * y_2
    x_3 = y_3 / d_3
    x_2 = y_2 / d_2 - l_32 * x_3
    x_1 = b_1 / a_11 - l_21 * x_2 - l_31 * x_3
    return x_1, x_2, x_3
