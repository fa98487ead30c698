"""The C source of exact derivatives of time steps and measurements, after that of the simulations."""

from functools import cache
from pathlib import Path

from prp_gym.physics.compiled_arm_source import SURFACE, arm_functions
from prp_gym.physics.compiled_link_source import link_function
from prp_gym.symbolic.c_source import c_function
from prp_gym.symbolic.derivatives import transposed

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
    return "\n".join([sizes, *reverse, _text("compiled_arm_reverse.c")])


@cache
def link_derivatives_source(timestep: float) -> str:
    """The same of the link, to stand after `link_source(timestep)`.

    Args:
        timestep: duration of a step [s].
    """
    wanted = ("q", "velocity", "torque")
    reverse = c_function(transposed(link_function(timestep), "prp_link_step_transposed", wanted))
    return "\n".join(["#include <string.h>", reverse, _text("compiled_link_reverse.c")])


@cache
def linearization_source(joint_count: int, measurement_size: int) -> str:
    """The C source of `prp_linearize` and `prp_linearize_measurement`, to stand after the derivatives.

    Args:
        joint_count: number of joints.
        measurement_size: largest number of columns of the measurement.
    """
    sizes = f"#define PRP_AXES {joint_count}\n#define PRP_MOST_MEASURED {measurement_size}\n"
    return f"{sizes}\n{_text('compiled_linearization.c')}"


def _text(name: str) -> str:
    """The text of a file beside this one."""
    return Path(__file__).with_name(name).read_text(encoding="utf-8")
