"""Formulas of components: the same for the columns of arrays and for the numbers of a single vector."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from prp_gym.robot.arrays import Array, zeros


def components(vectors: Array) -> list[Any]:
    """The components of vectors (..., n): arrays (...), of one vector numbers.

    A formula of components gives the same bits for numbers as for arrays, and is faster for a single vector.
    """
    if vectors.size == vectors.shape[-1] and type(vectors) is np.ndarray:
        numbers: list[Any] = vectors.ravel().tolist()
        return numbers
    return [vectors[..., index] for index in range(vectors.shape[-1])]


def sine_and_cosine(angle: Any) -> tuple[Any, Any]:
    """Sine and cosine of an array or of a number, of which NumPy and the module `math` have the same bits."""
    if type(angle) is float:
        return math.sin(angle), math.cos(angle)
    return np.sin(angle), np.cos(angle)


def from_components(values: Mapping[int, Any], shape: tuple[int, ...], reference: Array) -> Array:
    """An array of a shape from its entries, by their position in the flattened trailing axes; 0 elsewhere.

    Args:
        values: entries, numbers or arrays (...) as `components` gives them.
        shape: trailing axes of the result.
        reference: array (..., n) that was split into `components`.
    """
    count, lead = math.prod(shape), reference.shape[:-1]
    if reference.size == reference.shape[-1] and type(reference) is np.ndarray:
        entries = [0.0] * count
        for index, value in values.items():
            entries[index] = value
        return np.array(entries).reshape((*lead, *shape))
    result = zeros((*lead, count), reference)
    for index, value in values.items():
        result[..., index] = value
    return result.reshape((*lead, *shape))


def product(entries: Mapping[int, Any], rows: int, vector: list[Any]) -> list[Any]:
    """The components (rows) of a matrix times a vector of three components, summed in order.

    Args:
        entries: entries of the matrix (rows, 3), by their position in the flattened matrix; 0 elsewhere.
        rows: number of rows.
        vector: components (3).
    """
    x, y, z = vector
    row = range(0, 3 * rows, 3)
    return [entries.get(i, 0.0) * x + entries.get(i + 1, 0.0) * y + entries.get(i + 2, 0.0) * z for i in row]
