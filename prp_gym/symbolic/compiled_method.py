"""`CompiledMethod`: a method of an object in a compiled function, with the object's numbers as an input."""

import ctypes
from collections.abc import Callable, Hashable, Mapping, Sequence
from typing import Any, ClassVar

import numpy as np

from prp_gym.symbolic.array import SymbolicArray, untraceable
from prp_gym.symbolic.c_source import PREAMBLE, c_function
from prp_gym.symbolic.compiler import load_library
from prp_gym.symbolic.elementary_functions import has_bits_of_numpy
from prp_gym.symbolic.function import SymbolicFunction
from prp_gym.symbolic.lifting import Formula, LiftedFunction, numbers_of, trace_method
from prp_gym.symbolic.state_arrays import attributes, require_same


class CompiledMethod:
    """A compiled function of arguments and of the numbers that an object holds.

    Args:
        name: name of the function.
        formula: formula of the object, see `trace_method`.
        target: the object.
        shapes: shapes of the arguments.
        constants: classes of objects whose numbers are constants.
        kind: what tells the formula from others, see `trace_method`.

    Attributes:
        numbers: numbers of the object (P).
        function: address of the compiled function.
        decides_branches: whether numbers on which the formula branches stay inputs; see `trace_method`.

    Raises:
        UntraceableError: a formula that uses more than arithmetic on arrays.
        CompilerError: no compiler.
    """

    decides_branches: ClassVar[bool] = False

    def __init__(
        self,
        name: str,
        formula: Formula,
        target: Any,
        shapes: Mapping[str, tuple[int, ...]],
        constants: tuple[type, ...],
        kind: Hashable,
    ) -> None:
        self.numbers = numbers_of(target, constants)
        traced = trace_method(name, formula, target, shapes, constants, kind, decide=self.decides_branches)
        functions = self._functions(traced)
        self._formula = traced.function
        texts = [c_function(function, linkage="") for function in functions]
        self._library = load_library("\n".join([PREAMBLE, *texts]))
        self.function = ctypes.cast(self._library[functions[0].name], ctypes.c_void_p)

    @property
    def has_bits_of_numpy(self) -> bool:
        """Whether the compiled function gives the bits of the formula in NumPy, on this machine."""
        return has_bits_of_numpy(self._formula)

    def _functions(self, traced: LiftedFunction) -> tuple[SymbolicFunction, ...]:
        """The functions that are compiled, that of the formula first."""
        return (traced.function,)


def of_arguments_alone(target: Any, call: Callable[[], Sequence[Any]], like: SymbolicArray) -> Sequence[Any]:
    """What a call on an object returns, where that depends on the arguments alone.

    Args:
        target: the object, whose numbers are symbolic.
        call: calls a method, with new copies of the arguments.
        like: symbolic array of the same graph.

    Returns:
        the arrays that the call returns.

    Raises:
        UntraceableError: a call that changes the object, or returns something else the next time.
    """
    before = attributes(target)
    first = call()
    require_same(target, before)
    if _nodes(like, first) != _nodes(like, call()):
        raise untraceable(f"what {type(target).__name__} keeps outside of its state")
    return first


def _nodes(like: SymbolicArray, arrays: Sequence[Any]) -> list[Any]:
    """The expressions of arrays; equal ones are the same."""
    numbers = (SymbolicArray.of(like.graph, array.astype(np.float64)) for array in arrays)
    return [node for array in numbers for node in array.flat()]
