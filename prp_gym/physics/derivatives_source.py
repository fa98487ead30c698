"""The C source of exact derivatives of the arm's time step and measurement, after that of `arm_source`."""

from functools import cache
from pathlib import Path

from prp_gym.physics.compiled_arm_source import SURFACE, arm_functions
from prp_gym.symbolic.c_source import c_function
from prp_gym.symbolic.derivatives import transposed

_HAND_WRITTEN = Path(__file__).with_name("compiled_arm_reverse.c")
_WANTED = {
    "unconstrained": ("q", "velocity", "torque", "plant"),
    "friction_rows": ("q", "velocity", "plant"),
    "stop_rows": ("q", "velocity", "plant"),
    "surface_row": ("q", "velocity", "plant", "surface"),
    "advanced": ("q", "velocity", "plant", "B", "b"),
    "measured": ("q", "velocity"),
}
"""Functions of `arm_source`, with the arguments by which they are differentiated."""


@cache
def arm_derivatives_source(timestep: float) -> str:
    """The C source of `prp_step_reverse` and `prp_measured_reverse`, to stand after `arm_source(timestep)`.

    Both take the adjoints of results, the derivatives of a weighted sum of them, back to the adjoints of the
    state and the torque; `prp_step_adjoints` and `prp_measured_adjoints` also of the plant and the surface.
    Where a constraint changes its zone, the derivative is that of the zone in which it is.

    Args:
        timestep: duration of a step [s].

    Source: Griewank 2008, 3.2 and 15.1.
    """
    functions = arm_functions(timestep)
    reverse = [
        c_function(transposed(functions[name], f"prp_{name}_transposed", wanted))
        for name, wanted in _WANTED.items()
    ]
    sizes = f"#include <string.h>\n#define PRP_NORMAL {SURFACE['normal'].start}\n"
    return "\n".join([sizes, *reverse, _HAND_WRITTEN.read_text(encoding="utf-8")])
