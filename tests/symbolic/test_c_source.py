"""Generated C code: constants with all digits, shapes of arguments, outputs that are no operations."""

import os
import subprocess
import sys

import numpy as np

from prp_gym.symbolic.array import SymbolicArray
from prp_gym.symbolic.c_source import PREAMBLE, c_function
from prp_gym.symbolic.function import trace
from tests.symbolic.compilation import compile_together, require_compiler

CONSTANTS = np.array([np.pi, 0.1, -0.0, 0.0, 5e-324, -1e22, 1e-320, 2.0**60, np.inf, -np.inf, np.nan])
CALL = """
import ctypes, sys
from prp_gym.symbolic.compiler import load_library
result = (ctypes.c_double * 1)()
load_library(sys.stdin.read()).ratio((ctypes.c_double * 2)(-1.0, 1.0), result)
print(result[0])
"""


def test_outputs_may_be_inputs_constants_and_twice_the_same() -> None:
    def formula(x: SymbolicArray) -> dict[str, SymbolicArray]:
        constants = SymbolicArray.of(x.graph, CONSTANTS)
        return {"same": x, "constants": constants, "again": x[::-1], "nothing": x[:0]}

    function = trace("outputs", formula, {"x": (2, 3)})
    x = np.arange(6.0).reshape(2, 3)
    for found in (function.evaluate({"x": x}), compile_together([function])["outputs"]({"x": x})):
        np.testing.assert_array_equal(found["same"], x)
        np.testing.assert_array_equal(found["again"], x[::-1])
        np.testing.assert_array_equal(found["constants"], CONSTANTS)
        np.testing.assert_array_equal(np.signbit(found["constants"]), np.signbit(CONSTANTS))
        assert found["nothing"].shape == (0, 3)


def test_negative_constants_stand_beside_every_sign() -> None:
    def formula(x: SymbolicArray) -> dict[str, SymbolicArray]:
        return {"y": -(x - (-2.0)) - (-x) + (-3.0) * x}

    function = trace("signs", formula, {"x": (3,)})
    x = np.array([-1.5, 0.0, 7.0])
    np.testing.assert_array_equal(
        compile_together([function])["signs"]({"x": x})["y"], -(x + 2.0) + x - 3.0 * x
    )


def test_functions_of_one_file_share_its_preamble() -> None:
    functions = [
        trace(f"shared_{turns}", lambda x, turns=turns: {"y": x % float(turns)}, {"x": ()})
        for turns in (2, 3)
    ]
    compiled = compile_together(functions)
    found = [float(compiled[function.name]({"x": np.array(-1.0)})["y"]) for function in functions]
    assert found == [1.0, 2.0]


def test_linkage_stands_before_the_function() -> None:
    function = trace("linked", lambda x: {"y": x + 1.0}, {"x": ()})
    assert c_function(function).startswith("static inline void linked(")
    assert c_function(function, "extern").startswith("extern void linked(")


def test_ratio_of_truth_values_is_that_of_numbers() -> None:
    """In C they are integers, whose division by zero may end the process; hence a process of its own."""
    function = trace("ratio", lambda x: {"y": (x[0] < 0.0) / (x[1] < 0.0)}, {"x": (2,)})
    require_compiler()
    done = subprocess.run(
        [sys.executable, "-c", CALL],
        input=f"{PREAMBLE}\n{c_function(function, '')}",
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.stdout.strip() == "inf"
