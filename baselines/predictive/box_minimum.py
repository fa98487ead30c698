"""The minimum of a strictly convex quadratic function within bounds, exactly and without a branch."""

from typing import Any

import numpy as np

from prp_gym.robot.arrays import Array


def box_minimum(hessian: Array, gradient: Array, low: Array, high: Array) -> Array:
    """The minimum of ½ zᵀHz + gᵀz for low ≤ z ≤ high: (..., n, n), (..., n) -> (..., n).

    What remains of the function where all other components are at their best is a convex function of the
    first one: its minimum within the bounds is the minimum without them, clipped. Both parts are problems of
    n - 1 components, 2ⁿ⁻¹ clipped numbers in all.

    Args:
        hessian: H (..., n, n), symmetric and positive definite.
        gradient: g (..., n).
        low: lower bounds (..., n).
        high: upper bounds (..., n), above the lower ones.

    Source: Boyd 2004, 3.2.5.
    """
    rows = range(gradient.shape[-1])
    H = [[hessian[..., row, column] for column in rows] for row in rows]
    vectors = ([vector[..., row] for row in rows] for vector in (gradient, low, high))
    return np.stack(_minimum(H, *vectors), axis=-1)


def _minimum(H: list[list[Any]], g: list[Any], low: list[Any], high: list[Any]) -> list[Any]:
    """The components of `box_minimum`."""
    pivot, column, inner = H[0][0], [row[0] for row in H[1:]], [row[1:] for row in H[1:]]
    best = -g[0]
    if inner:
        factors = [entry / pivot for entry in column]
        schur = [
            [entry - factor * other for entry, other in zip(row, column, strict=True)]
            for row, factor in zip(inner, factors, strict=True)
        ]
        reduced = [part - factor * g[0] for part, factor in zip(g[1:], factors, strict=True)]
        for entry, rest in zip(column, _minimum(schur, reduced, low[1:], high[1:]), strict=True):
            best = best - entry * rest
    first = np.minimum(np.maximum(best / pivot, low[0]), high[0])
    if not inner:
        return [first]
    given = [part + entry * first for part, entry in zip(g[1:], column, strict=True)]
    return [first, *_minimum(inner, given, low[1:], high[1:])]
