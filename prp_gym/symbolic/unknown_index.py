"""Elements of symbolic arrays at an index that is known only when the formula runs."""

from typing import Any, TypeVar

import numpy as np

from prp_gym.symbolic.array import SymbolicArray, elementwise, untraceable
from prp_gym.symbolic.operations import WHERE

ArrayT = TypeVar("ArrayT", bound=SymbolicArray)


def elements_at(array: ArrayT, keys: tuple[Any, ...]) -> ArrayT:
    """The elements at an unknown index: a choice between those at every position of its axis.

    Args:
        array: symbolic array.
        keys: indices, one for each axis from the first on, of which one is symbolic.

    Raises:
        UntraceableError: several unknown indices, truth values, or a slice before the index.
    """
    axis = _unknown_axis(keys)
    before, after = keys[:axis], keys[axis + 1 :]
    shape = np.broadcast_shapes(keys[axis].shape, *(np.shape(part) for part in before))
    index = _like(array, np.broadcast_to(keys[axis].nodes, shape))

    def taken(position: int) -> ArrayT:
        return _like(array, array.nodes[(*before, np.full(shape, position), *after)])

    count, result = array.shape[axis], taken(0)
    wide: Any = index.reshape((*shape, *(1,) * (result.ndim - index.ndim)))
    for position in range(1, count):
        here = (wide == float(position)) | (wide == float(position - count))
        result = _like(array, elementwise(array.graph, WHERE, here, taken(position), result))
    return result


def _unknown_axis(keys: tuple[Any, ...]) -> int:
    """The axis of the unknown index."""
    unknown = [axis for axis, part in enumerate(keys) if isinstance(part, SymbolicArray)]
    if len(unknown) != 1:
        raise untraceable("an index with several unknown numbers")
    (axis,) = unknown
    if any(node.is_boolean for node in keys[axis].flat()):
        raise untraceable("a choice of elements by truth values; write numpy.where: such a choice")
    if any(part is None or part is Ellipsis or isinstance(part, slice) for part in keys[:axis]):
        raise untraceable("an unknown index after a slice")
    return axis


def _like(array: ArrayT, nodes: Any) -> ArrayT:
    return type(array)(array.graph, nodes)
