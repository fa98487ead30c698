"""Whether compiled code has the sines, exponentials and the like of NumPy is found out on this machine."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from prp_gym.errors import CompilerError
from prp_gym.symbolic import elementary_functions
from prp_gym.symbolic.elementary_functions import elementary_functions_agree, has_bits_of_numpy
from prp_gym.symbolic.function import SymbolicFunction, trace
from prp_gym.symbolic.operations import OPERATIONS, SINE
from tests.support.compiler import needs_compiler

again = elementary_functions_agree.__wrapped__  # without the cache


def traced(formula: Callable[..., Any]) -> SymbolicFunction:
    return trace("prp_one", lambda x: {"y": formula(x)}, {"x": (1,)})


@needs_compiler
def test_all_functions_whose_rounding_is_not_prescribed_are_tried(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each is replaced by one that differs in the last bit of most results."""
    inexact = [operation for operation in OPERATIONS if not operation.exact]
    assert {operation.name for operation in inexact} >= {"sin", "cos", "exp", "log", "power", "arctan2"}
    assert again()
    for operation in inexact:
        wrong = replace(operation, text=f"({operation.text}) * (1.0 + 2.3e-16)")
        tried = tuple(wrong if other is operation else other for other in inexact)
        monkeypatch.setattr(elementary_functions, "_TRIED", tried)
        assert not again()


def test_without_compiler_nothing_agrees(monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(_: str) -> None:
        raise CompilerError("no compiler")

    monkeypatch.setattr(elementary_functions, "load_library", refused)
    assert not again()


def test_arithmetic_has_the_bits_of_numpy_everywhere(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(elementary_functions, "elementary_functions_agree", lambda: False)
    assert has_bits_of_numpy(traced(np.sqrt))
    assert not has_bits_of_numpy(traced(SINE.ufunc))
