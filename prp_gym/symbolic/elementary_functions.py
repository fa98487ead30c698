"""Whether compiled code has the same sines, exponentials and the like as the formulas in NumPy.

Both take them from the mathematical library of the machine, if NumPy and the compiler were built to do so.
IEEE 754 does not say how these functions round, so that this is tried out.
"""

import ctypes
from functools import cache

import numpy as np

from prp_gym.errors import CompilerError
from prp_gym.symbolic.c_source import PREAMBLE
from prp_gym.symbolic.compiler import load_library
from prp_gym.symbolic.function import SymbolicFunction
from prp_gym.symbolic.operations import OPERATIONS

_TRIED = tuple(operation for operation in OPERATIONS if not operation.exact)
_COUNT = 4096  # arguments of each function


def has_bits_of_numpy(function: SymbolicFunction) -> bool:
    """Whether compiled code gives the bits that the formula has in NumPy, on this machine."""
    return function.is_exact or elementary_functions_agree()


@cache
def elementary_functions_agree() -> bool:
    """Whether all functions whose rounding is not prescribed agree on thousands of arguments."""
    try:
        library = load_library(elementary_source())
    except CompilerError:
        return False
    first, second = _arguments()
    results = np.empty((len(_TRIED), _COUNT))
    pointers = (ctypes.c_void_p(array.ctypes.data) for array in (first, second, results))
    library.prp_try_elementary(ctypes.c_long(_COUNT), *pointers)
    expected = [operation.of_arrays(*(first, second)[: _arity(operation.text)]) for operation in _TRIED]
    return bool(np.array_equal(results, np.array(expected)))


def elementary_source() -> str:
    """The C source of the functions that are tried out."""
    lines = [
        f"        results[{row} * count + i] = {operation.text.format('first[i]', 'second[i]')};\n"
        for row, operation in enumerate(_TRIED)
    ]
    head = "void prp_try_elementary(long count, const double *first, const double *second, double *results)"
    return f"{PREAMBLE}\n{head}\n{{\n    for (long i = 0; i < count; i++) {{\n{''.join(lines)}    }}\n}}\n"


def _arguments() -> tuple[np.ndarray, np.ndarray]:
    """Positive numbers of many magnitudes, as bases, angles and exponents, and numbers of both signs."""
    rng = np.random.default_rng(0)
    return 10.0 ** rng.uniform(-8.0, 2.0, _COUNT), rng.uniform(-3.0, 3.0, _COUNT)


def _arity(text: str) -> int:
    return 2 if "{1}" in text else 1
