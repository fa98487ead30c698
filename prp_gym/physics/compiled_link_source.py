"""The C source of the simulated link: the function generated from its formula, and the loop that calls it."""

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from prp_gym.robot.arrays import Array
from prp_gym.symbolic.c_source import PREAMBLE, c_function
from prp_gym.symbolic.function import SymbolicFunction, trace

_HAND_WRITTEN = ("compiled_world.h", "compiled_link.c")


def link_step(q: Array, velocity: Array, torque: Array, plant: Array, timestep: float) -> tuple[Array, Array]:
    """Position and velocity of links (..., 1) a step later: (I + h F) q̇' = I q̇ + h (τ - G sin q).

    Args:
        q: joint position (..., 1) [rad].
        velocity: joint velocity (..., 1) [rad/s].
        torque: τ (..., 1) [N m].
        plant: I, F and G (..., 3) [kg m^2, N m s/rad, N m].
        timestep: h [s].

    Source: [R] 8.1; [M] Computation, Numerical integration.
    """
    inertia, friction, gravity = plant[..., :1], plant[..., 1:2], plant[..., 2:]
    force = torque - friction * velocity - gravity * np.sin(q)
    velocity = velocity + timestep * (force / (inertia + timestep * friction))
    return q + timestep * velocity, velocity


@cache
def link_function(timestep: float) -> SymbolicFunction:
    """The traced step of a link.

    Args:
        timestep: duration of a step [s].
    """

    def step(q: Any, velocity: Any, torque: Any, plant: Any) -> Mapping[str, Any]:
        later, faster = link_step(q, velocity, torque, plant, timestep)
        return {"later": later, "faster": faster}

    return trace("prp_link_step", step, {"q": (1,), "velocity": (1,), "torque": (1,), "plant": (3,)})


@cache
def link_source(timestep: float) -> str:
    """The C source of simulations with a duration of steps [s]."""
    loop = [Path(__file__).with_name(name).read_text(encoding="utf-8") for name in _HAND_WRITTEN]
    return "\n".join([PREAMBLE, c_function(link_function(timestep)), *loop])
