"""`RowFunction`: a formula over rows, in compiled code where that gives the bits of NumPy."""

import ctypes
import math
from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple, Self

import numpy as np

from prp_gym.errors import CompilerError, UntraceableError
from prp_gym.symbolic.c_source import PREAMBLE, c_function
from prp_gym.symbolic.compiler import compiles_by_default, load_library
from prp_gym.symbolic.elementary_functions import has_bits_of_numpy
from prp_gym.symbolic.function import Symbols, trace

Formula = Callable[..., Mapping[str, Any]]
Shapes = Mapping[str, tuple[int, ...]]


class _Code(NamedTuple):
    """Compiled code of a formula.

    Attributes:
        function: compiled function of the number of rows, their arguments and their results.
        arguments: columns of each argument in a row.
        results: columns and shape of each result in a row.
        sizes: number of columns of the arguments, and of the results.
    """

    function: Any
    arguments: Mapping[str, slice]
    results: Mapping[str, tuple[slice, tuple[int, ...]]]
    sizes: tuple[int, int]


class RowFunction:
    """A function of arrays with n rows, whose results depend on the arguments in the same row alone.

    A call of NumPy takes about a microsecond, however few the numbers are, and a formula of a hundred calls a
    hundred. Compiled code has the same bits; NumPy computes what cannot be compiled. Zeros are positive in
    either case.

    Args:
        name: name of the function in C.
        formula: formula of arrays (n, ...) by name, which returns its results by name.
        shapes: shapes of the arguments without their rows.
    """

    def __init__(self, name: str, formula: Formula, shapes: Shapes) -> None:
        self._name, self._formula, self._shapes = name, formula, dict(shapes)
        self._code: _Code | None = None
        self._is_tried, self._count = False, 0

    @property
    def is_compiled(self) -> bool:
        """Whether the last call was one of compiled code."""
        return self._code is not None

    def __call__(self, **arguments: Any) -> Mapping[str, Any]:
        """The results of numbers.

        Args:
            arguments: arrays (n, ...) by name.
        """
        if not self._is_tried:
            self._code, self._is_tried = self._compiled(), True
        if self._code is None:
            return {name: values + 0.0 for name, values in self._formula(**arguments).items()}
        count = len(next(iter(arguments.values())))
        if count != self._count:
            self._make_rows(self._code, count)
        for name, columns in self._columns.items():
            columns[...] = arguments[name]
        self._code.function(*self._call)
        results = self._results.copy()
        return {name: _part(results, *where) for name, where in self._code.results.items()}

    def _make_rows(self, code: _Code, count: int) -> None:
        """Make the arrays that compiled code reads and writes."""
        given, self._results = (np.zeros((count, size)) for size in code.sizes)
        shapes = self._shapes
        self._columns = {n: given[:, c].reshape((count, *shapes[n])) for n, c in code.arguments.items()}
        addresses = (ctypes.c_void_p(array.ctypes.data) for array in (given, self._results))
        self._call, self._given, self._count = (ctypes.c_long(count), *addresses), given, count

    def _compiled(self) -> _Code | None:
        """The compiled code; None where there is none that has the bits of NumPy."""
        if not compiles_by_default():
            return None
        try:
            shapes = {name: (1, *shape) for name, shape in self._shapes.items()}
            function = trace(self._name, self._formula, shapes)
            if not has_bits_of_numpy(function):
                return None
            own = _loop(self._name, function.inputs, function.outputs)
            library = load_library("\n".join([PREAMBLE, c_function(function), own]))
        except (UntraceableError, CompilerError):
            return None
        arguments, results = dict(_columns(function.inputs)), dict(_columns(function.outputs))
        wheres = {name: (columns, function.outputs[name].shape[1:]) for name, columns in results.items()}
        sizes = _size(function.inputs), _size(function.outputs)
        return _Code(library[f"{self._name}_rows"], arguments, wheres, sizes)

    def __deepcopy__(self, _: Any) -> Self:
        own = type(self)(self._name, self._formula, self._shapes)
        own._code, own._is_tried = self._code, self._is_tried
        return own

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self._name, self._formula, self._shapes)


def _part(results: Any, columns: slice, shape: tuple[int, ...]) -> Any:
    """One result in rows of all results."""
    part = results[:, columns]
    return part if len(shape) == 1 else part.reshape((len(part), *shape))


def _size(arrays: Symbols) -> int:
    return sum(array.size for array in arrays.values())


def _columns(arrays: Symbols) -> Iterator[tuple[str, slice]]:
    """The columns of each array in a row."""
    first = 0
    for name, array in arrays.items():
        yield name, slice(first, first := first + math.prod(array.shape))


def _loop(name: str, inputs: Symbols, outputs: Symbols) -> str:
    """The C function that computes all rows."""
    pointers = [f"given + {columns.start}" for _, columns in _columns(inputs)]
    pointers += [f"results + {columns.start}" for _, columns in _columns(outputs)]
    return f"""
void {name}_rows(long count, const double *given, double *results)
{{
    for (long row = 0; row < count; row++, given += {_size(inputs)}, results += {_size(outputs)}) {{
        {name}({", ".join(pointers)});
        for (int i = 0; i < {_size(outputs)}; i++)
            results[i] += 0.0; /* no negative zeros */
    }}
}}
"""
