"""`SymbolicArray`: an array of expressions that NumPy's functions accept in place of numbers."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Self

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

from prp_gym.errors import DataDependentBranchError, UntraceableError, shortened
from prp_gym.symbolic.graph import Graph, Node
from prp_gym.symbolic.operations import AND, NOT_EQUAL, OPERATIONS, OR, SINGLE, WHERE, Operation

_OF_UFUNC = {operation.ufunc: operation for operation in OPERATIONS}
_OF_UFUNC |= {np.bitwise_and: AND, np.bitwise_or: OR, np.invert: _OF_UFUNC[np.logical_not]}


_OPTIONS = {True: {"axis", "keepdims", "out"}, False: {"out", "where"}}
"""Options of a reduction and of a call that have a meaning for expressions."""


class SymbolicArray(NDArrayOperatorsMixin):
    """Expressions in the place of an array's numbers.

    A formula that is written for arrays, with NumPy's functions, indices and assignments, runs on symbolic
    arrays as it is; the expressions of its result are the formula, unrolled over the components. What depends
    on numbers that are not known, a branch or a conversion, is refused.

    Args:
        graph: graph of the expressions.
        nodes: expressions, an array of any shape that holds nodes.
    """

    __slots__ = ("graph", "nodes")

    def __init__(self, graph: Graph, nodes: Any) -> None:
        self.graph, self.nodes = graph, nodes

    @classmethod
    def inputs(cls, graph: Graph, name: str, shape: tuple[int, ...]) -> Self:
        """An array of inputs `name[0]`, `name[1]`, ... in the order of the flat array."""
        nodes = np.empty(shape, dtype=object)
        for position, index in enumerate(np.ndindex(shape)):
            nodes[index] = graph.input(f"{name}[{position}]")
        return cls(graph, nodes)

    @classmethod
    def of(cls, graph: Graph, values: Any) -> Self:
        """Numbers, or a symbolic array as it is, as a symbolic array."""
        if isinstance(values, cls):
            return values
        numbers = np.asarray(values, dtype=np.float64)
        nodes = np.empty(numbers.shape, dtype=object)
        for index in np.ndindex(numbers.shape):
            nodes[index] = graph.constant(float(numbers[index]))
        return cls(graph, nodes)

    def zeros(self, shape: tuple[int, ...]) -> Self:
        """Zeros of the same graph."""
        nodes = np.empty(shape, dtype=object)
        nodes.fill(self.graph.constant(0.0))
        return type(self)(self.graph, nodes)

    @property
    def shape(self) -> tuple[int, ...]:
        """As that of an array."""
        return tuple(self.nodes.shape)

    @property
    def ndim(self) -> int:
        """As that of an array."""
        return len(self.shape)

    @property
    def size(self) -> int:
        """As that of an array."""
        return int(self.nodes.size)

    @property
    def mT(self) -> Self:  # noqa: N802  as NumPy names it
        """As that of an array."""
        return self._like(np.swapaxes(self.nodes, -1, -2))

    def copy(self) -> Self:
        """As that of an array."""
        return self._like(self.nodes.copy())

    def astype(self, dtype: Any) -> SymbolicArray:
        """As that of an array: rounded to single precision, truth values as numbers, or numbers as these."""
        kind = np.dtype(dtype)
        if kind == np.float32:
            from prp_gym.symbolic.single_array import SingleArray  # a kind of this class

            return SingleArray(self.graph, elementwise(self.graph, SINGLE, self.numbers()))
        if kind == np.float64:
            return self.numbers()
        if kind == np.bool_:
            return self._booleans()
        raise untraceable(f"the conversion to {kind}")

    def reshape(self, *shape: Any) -> Self:
        """As that of an array."""
        return self._like(self.nodes.reshape(*shape))

    def any(self, axis: int | None = None, keepdims: bool = False) -> Self:
        """As that of an array."""
        return self._like(self._booleans()._reduced(OR, axis, keepdims))

    def all(self, axis: int | None = None, keepdims: bool = False) -> Self:
        """As that of an array."""
        return self._like(self._booleans()._reduced(AND, axis, keepdims))

    def max(self, axis: int | None = None, keepdims: bool = False) -> Self:
        """As that of an array."""
        return self._like(self._reduced(_OF_UFUNC[np.maximum], axis, keepdims))

    def sum(self, axis: int | None = None, keepdims: bool = False) -> Self:
        """As that of an array; truth values count as 0 and 1."""
        return self._like(self.numbers()._reduced(_OF_UFUNC[np.add], axis, keepdims))

    def numbers(self) -> Self:
        """The same with 1 and 0 in place of truth values."""
        return self.map(lambda node: self.graph.apply(WHERE, node, 1.0, 0.0) if node.is_boolean else node)

    def map(self, function: Any) -> Self:
        """A function of every node."""
        nodes = np.empty(self.shape, dtype=object)
        for index in np.ndindex(self.shape):
            nodes[index] = function(self.nodes[index])
        return self._like(nodes)

    def flat(self) -> list[Node]:
        """The nodes in the order of the flat array."""
        return list(self.nodes.ravel())

    def __len__(self) -> int:
        return len(self.nodes)

    def __iter__(self) -> Iterator[Self]:
        return (self[index] for index in range(len(self)))

    def __getitem__(self, key: Any) -> Self:
        keys = key if isinstance(key, tuple) else (key,)
        if any(isinstance(part, SymbolicArray) for part in keys):
            from prp_gym.symbolic.unknown_index import elements_at  # a function of this class

            return elements_at(self, keys)
        found = np.empty((), dtype=object)
        if isinstance(taken := self.nodes[key], Node):
            found[()] = taken
            return self._like(found)
        return self._like(taken)

    def __setitem__(self, key: Any, value: Any) -> None:
        nodes = type(self).of(self.graph, value).nodes
        self.nodes[key] = nodes if nodes.ndim else nodes[()]  # NumPy would store an array of no dimension

    def __bool__(self) -> bool:
        if self.size == 1:
            node = self.flat()[0]
            outcome = bool(node.value) if node.is_constant else self.graph.decide(node)
            if outcome is not None:
                return outcome
        self.graph.undecided = tuple(self.flat())
        branch = f"a branch on {shortened(self)} cannot be traced into compiled code"
        raise DataDependentBranchError(f"{branch}; write numpy.where in its place.")

    def __float__(self) -> float:
        if self.size == 1 and (node := self.flat()[0]).is_constant:
            return node.value
        self.graph.undecided = tuple(self.flat())
        raise DataDependentBranchError(
            f"the conversion of {shortened(self)} to a number cannot be traced into compiled code."
        )

    def __array__(self, *_: Any, **__: Any) -> Any:
        raise untraceable("the conversion of unknown numbers to an array of numbers")

    def __repr__(self) -> str:
        return f"SymbolicArray({self.nodes.tolist()!r})"

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **options: Any) -> Any:
        if set(options) - _OPTIONS[method == "reduce"]:
            raise untraceable(f"numpy.{ufunc.__name__} with {', '.join(sorted(options))}")
        if method == "reduce":
            reduced = self._reduced(_operation(ufunc), options.get("axis", 0), options.get("keepdims", False))
            return self._result(reduced, options)
        if method != "__call__":
            raise untraceable(f"numpy.{ufunc.__name__}.{method}")
        if ufunc is np.square or (ufunc is np.power and _is_two(inputs[1])):
            ufunc, inputs = np.multiply, (inputs[0], inputs[0])
        if ufunc is np.add and all(map(holds_truth_values, inputs)) and any(map(_has_boolean, inputs)):
            ufunc = np.logical_or  # as NumPy adds truth values
        if ufunc is np.invert and not all(map(holds_truth_values, inputs)):
            raise untraceable("numpy.invert of numbers")
        if "where" not in options:
            return self._result(elementwise(self.graph, _operation(ufunc), *inputs), options)
        if "out" not in options:
            raise untraceable(f"numpy.{ufunc.__name__} with where and without out")
        # what is left out must not even have an infinite derivative: there, the last argument is 1
        last = self._like(elementwise(self.graph, WHERE, options["where"], inputs[-1], 1.0))
        nodes = elementwise(self.graph, _operation(ufunc), *inputs[:-1], last)
        nodes = elementwise(self.graph, WHERE, options["where"], self._like(nodes), options["out"][0])
        return self._result(nodes, options)

    def __array_function__(self, function: Any, _: Any, arguments: Any, options: Any) -> Any:
        from prp_gym.symbolic.array_functions import ARRAY_FUNCTIONS  # they are functions of this class

        if function not in ARRAY_FUNCTIONS:
            raise untraceable(f"numpy.{function.__name__}")
        return ARRAY_FUNCTIONS[function](self.graph, *arguments, **options)

    def _like(self, nodes: Any) -> Self:
        return type(self)(self.graph, nodes)

    def _result(self, nodes: Any, options: dict[str, Any]) -> Any:
        """A result, written into the array that was given for it."""
        if "out" not in options:
            return self._like(nodes)
        (out,) = options["out"]
        if not isinstance(out, SymbolicArray):
            raise untraceable("unknown numbers written into an array of numbers")
        out.nodes[...] = nodes
        return out

    def _reduced(self, operation: Operation, axis: Any, keepdims: bool) -> Any:
        """The operation over an axis, in the order of its components; over all of them for None."""
        if axis is not None and not isinstance(axis, int):
            raise untraceable("a reduction over several axes")
        nodes = self.nodes.ravel() if axis is None else np.moveaxis(self.nodes, axis, 0)
        result = np.asarray(nodes[0], dtype=object)
        for row in nodes[1:]:
            result = elementwise(self.graph, operation, self._like(result), self._like(np.asarray(row)))
        axes = tuple(range(self.ndim)) if axis is None else axis
        return np.expand_dims(result, axes) if keepdims else result

    def _booleans(self) -> Self:
        """Whether the elements differ from zero."""
        return self.map(lambda node: node if node.is_boolean else self.graph.apply(NOT_EQUAL, node, 0.0))


def _is_two(exponent: Any) -> bool:
    return not isinstance(exponent, SymbolicArray) and np.array_equal(exponent, 2)


def holds_truth_values(values: Any) -> bool:
    """Whether an argument is an array of truth values."""
    if isinstance(values, SymbolicArray):
        return all(node.is_boolean or node.is_constant for node in values.flat())
    return np.asarray(values).dtype == np.bool_


def _has_boolean(values: Any) -> bool:
    """Whether an argument holds a truth value other than the constants, which are numbers too."""
    if isinstance(values, SymbolicArray):
        return any(node.is_boolean for node in values.flat())
    return True  # an array of truth values, as `holds_truth_values` has found


def elementwise(graph: Graph, operation: Operation, *values: Any) -> Any:
    """An operation on every element of arrays that broadcast; an array of nodes."""
    arrays: Any = np.broadcast_arrays(*(SymbolicArray.of(graph, value).nodes for value in values))
    nodes = np.empty(arrays[0].shape, dtype=object)
    for index in np.ndindex(nodes.shape):
        nodes[index] = graph.apply(operation, *(array[index] for array in arrays))
    return nodes


def untraceable(operation: str) -> UntraceableError:
    """The error about an operation that has no meaning for expressions."""
    return UntraceableError(f"{operation} cannot be traced into compiled code.")


def is_symbolic(value: object) -> bool:
    """Whether a value is a symbolic array, in the place of an array while a formula is traced."""
    return type(value) is SymbolicArray


def _operation(ufunc: Any) -> Operation:
    if ufunc not in _OF_UFUNC:
        raise untraceable(f"numpy.{ufunc.__name__}")
    return _OF_UFUNC[ufunc]
