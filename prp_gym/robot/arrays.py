"""Conversion and shape checks of joint vectors and tip positions, and products over leading dimensions."""

import numpy as np
from numpy.typing import ArrayLike

from prp_gym.checks import Array, as_array, check_finite
from prp_gym.errors import InvalidValueError, ShapeError

__all__ = [
    "Array",
    "apply",
    "apply_transposed",
    "as_vectors",
    "broadcast",
    "matrix_like",
    "solve",
    "solve_least_squares",
]


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
    try:
        return tuple(np.broadcast_arrays(*arrays))
    except ValueError:
        shapes = ", ".join(str(array.shape) for array in arrays)
        raise InvalidValueError("leading dimensions", shapes, "dimensions that broadcast") from None


def matrix_like(reference: Array, rows: int, columns: int) -> Array:
    """Zeros (..., rows, columns) with the leading dimensions of `reference`."""
    return np.zeros((*reference.shape[:-1], rows, columns))


def apply(matrix: Array, vector: Array) -> Array:
    """Matrix times vector over leading dimensions: (..., m, n), (..., n) -> (..., m)."""
    product: Array = np.matmul(matrix, vector[..., None])[..., 0]
    return product


def apply_transposed(matrix: Array, vector: Array) -> Array:
    """Transposed matrix times vector: (..., m, n), (..., m) -> (..., n)."""
    return apply(np.swapaxes(matrix, -1, -2), vector)


def solve_least_squares(matrix: Array, vector: Array, damping: float = 0.0) -> Array:
    """Damped pseudoinverse times vector, (AᵀA + λ²I)⁻¹Aᵀb: (..., m, n), (..., m) -> (..., n).

    Args:
        matrix: A (..., m, n) with m >= n; it must have full column rank if the damping is zero.
        vector: b (..., m).
        damping: λ, in the units of A's singular values.

    Source: [S] 3.5.
    """
    transposed = np.swapaxes(matrix, -1, -2)
    normal = np.matmul(transposed, matrix)
    if damping > 0.0:
        normal = normal + damping**2 * np.eye(matrix.shape[-1])
    return solve(normal, np.matmul(transposed, vector[..., None])[..., 0])


def solve(matrix: Array, vector: Array) -> Array:
    """The solution x of A x = b: (..., n, n), (..., n) -> (..., n).

    Raises:
        InvalidValueError: a matrix that is singular, as for parameters of very different magnitudes.
    """
    try:
        return np.asarray(np.linalg.solve(matrix, vector[..., None])[..., 0], dtype=np.float64)
    except np.linalg.LinAlgError:
        raise InvalidValueError("matrix", matrix.tolist(), "one that can be inverted") from None
