"""NumPy's functions of whole arrays, for symbolic arrays."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from prp_gym.symbolic.array import SymbolicArray, elementwise
from prp_gym.symbolic.graph import Graph
from prp_gym.symbolic.operations import MAXIMUM, MINIMUM, WHERE


def _joined(join: Callable[..., Any]) -> Callable[..., SymbolicArray]:
    """`stack` or `concatenate`."""

    def function(graph: Graph, arrays: Sequence[Any], axis: int = 0) -> SymbolicArray:
        return SymbolicArray(graph, join([SymbolicArray.of(graph, array).nodes for array in arrays], axis))

    return function


def _rearranged(rearrange: Callable[..., Any]) -> Callable[..., SymbolicArray]:
    """A function that moves elements."""

    def function(graph: Graph, array: Any, *arguments: Any, **options: Any) -> SymbolicArray:
        return SymbolicArray(graph, rearrange(SymbolicArray.of(graph, array).nodes, *arguments, **options))

    return function


def _clip(graph: Graph, values: Any, low: Any, high: Any) -> SymbolicArray:
    clipped = SymbolicArray.of(graph, values)
    for operation, bound in ((MAXIMUM, low), (MINIMUM, high)):
        if bound is not None:
            clipped = SymbolicArray(graph, elementwise(graph, operation, clipped, bound))
    return clipped


def _where(graph: Graph, condition: Any, yes: Any, no: Any) -> SymbolicArray:
    return SymbolicArray(graph, elementwise(graph, WHERE, condition, yes, no))


def _zeros_like(graph: Graph, array: Any, *_: Any, shape: Any = None, **__: Any) -> SymbolicArray:
    wanted = array.shape if shape is None else shape
    return SymbolicArray.of(graph, np.zeros(wanted))


def _broadcast_arrays(graph: Graph, *arrays: Any) -> list[SymbolicArray]:
    nodes = np.broadcast_arrays(*(SymbolicArray.of(graph, array).nodes for array in arrays))
    return [SymbolicArray(graph, array) for array in nodes]


def _count_nonzero(_: Graph, values: Any, axis: int | None = None) -> SymbolicArray:
    counted: SymbolicArray = values.astype(np.bool_).sum(axis=axis)
    return counted


ARRAY_FUNCTIONS: dict[Any, Callable[..., Any]] = {
    np.broadcast_arrays: _broadcast_arrays,
    np.broadcast_to: _rearranged(lambda nodes, shape: np.broadcast_to(nodes, shape).copy()),
    np.clip: _clip,
    np.concatenate: _joined(np.concatenate),
    np.count_nonzero: _count_nonzero,
    np.copy: _rearranged(np.copy),
    np.diagonal: _rearranged(np.diagonal),
    np.empty_like: _zeros_like,
    np.expand_dims: _rearranged(np.expand_dims),
    np.moveaxis: _rearranged(np.moveaxis),
    np.reshape: _rearranged(np.reshape),
    np.stack: _joined(np.stack),
    np.swapaxes: _rearranged(np.swapaxes),
    np.transpose: _rearranged(np.transpose),
    np.where: _where,
    np.zeros_like: _zeros_like,
}
"""By NumPy's own function; each takes the graph first."""
