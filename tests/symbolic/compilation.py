"""What tests of generated code share: symbolic functions compiled together and called with arrays."""

import ctypes
import re
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from prp_gym.errors import CompilerError
from prp_gym.symbolic.c_source import PREAMBLE, c_function
from prp_gym.symbolic.compiler import find_compiler, load_library
from prp_gym.symbolic.function import SymbolicFunction
from prp_gym.symbolic.operations import Operation

Array = NDArray[np.float64]


def arity(operation: Operation) -> int:
    """The number of arguments."""
    return len(set(re.findall(r"\{\d\}", operation.text)))


class CompiledFunction:
    """A symbolic function in machine code, called as `SymbolicFunction.evaluate` is.

    Args:
        function: symbolic function.
        library: library that holds its code.
    """

    def __init__(self, function: SymbolicFunction, library: ctypes.CDLL) -> None:
        self._shapes = {name: array.shape for name, array in function.inputs.items()}
        self._results = {name: array.shape for name, array in function.outputs.items()}
        self._code: Any = getattr(library, function.name)
        self._code.restype = None

    def __call__(self, values: Mapping[str, Array]) -> dict[str, Array]:
        """The results of numbers."""
        given = [np.array(values[name]).reshape(shape) for name, shape in self._shapes.items()]
        results = {name: np.full(shape, np.nan) for name, shape in self._results.items()}
        arrays = [np.ascontiguousarray(array, dtype=np.float64) for array in given]
        self._code(*(ctypes.c_void_p(array.ctypes.data) for array in (*arrays, *results.values())))
        return results


def require_compiler() -> None:
    """Skip the test where there is no compiler."""
    try:
        find_compiler()
    except CompilerError as error:
        pytest.skip(str(error))


def compile_together(functions: Iterable[SymbolicFunction]) -> dict[str, CompiledFunction]:
    """Functions by name, compiled from one file; the test is skipped where there is no compiler."""
    require_compiler()
    together = list(functions)
    library = load_library("\n".join([PREAMBLE, *(c_function(each, "") for each in together)]))
    return {each.name: CompiledFunction(each, library) for each in together}
