"""The C source of the simulated arm: functions generated from the formulas, and the loop that calls them."""

from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from prp_gym.physics.closed_form import ClosedForm, PlantArm, Rows, SurfaceRows, surface_force
from prp_gym.physics.plant_rows import plant_row
from prp_gym.robot.arm import PRPArm
from prp_gym.robot.arrays import Array, apply, solve_symmetric
from prp_gym.robot.dynamics import BaseParameters
from prp_gym.robot.parameters import NOMINAL
from prp_gym.symbolic.array import SymbolicArray
from prp_gym.symbolic.c_source import PREAMBLE, c_function
from prp_gym.symbolic.function import SymbolicFunction, trace
from prp_gym.symbolic.graph import Graph, Node
from prp_gym.symbolic.operations import COSINE, SINE
from prp_gym.symbolic.rewriting import rewritten

_HAND_WRITTEN = ("compiled_world.h", "constraint_solver.c", "compiled_arm.c")

PLANT = {
    "base_parameters": slice(0, 6),
    "viscous_friction": slice(6, 9),
    "joint_inverse_weight": slice(9, 12),
    "tip_inverse_weight": slice(12, 13),
    "coulomb_friction": slice(13, 16),
}
"""Columns of a plant, see `ClosedForm`."""

PLANT_SIZE = 16

SURFACE = {
    "stiffness": slice(0, 1),
    "damping": slice(1, 2),
    "point": slice(2, 5),
    "velocity": slice(5, 8),
    "normal": slice(8, 11),
}
"""Columns of a surface, see `SurfaceRows`."""

SURFACE_SIZE = 11

_TURNS = ("", "sin(q[0])", "cos(q[0])", "", "sin(q[2])", "cos(q[2])")

TURNS_SIZE = len(_TURNS)
"""Columns of the angles of the first and the third joint, each with its sine and its cosine."""

_SIZES = (
    f"#define PRP_PLANT {PLANT_SIZE}\n#define PRP_SURFACE {SURFACE_SIZE}\n"
    f"#define PRP_COULOMB {PLANT['coulomb_friction'].start}\n"
)
_STATE = {"q": (3,), "velocity": (3,)}
_FORCES = {"B": (3, 3), "b": (3,)}


def closed_form(plant: Array, timestep: float) -> ClosedForm:
    """The arms whose plants are the rows of an array (..., `PLANT_SIZE`)."""
    base = plant[..., PLANT["base_parameters"]]
    values: list[Any] = [base[..., index] for index in range(6)]
    viscous_friction = plant[..., PLANT["viscous_friction"]]
    return ClosedForm(
        PlantArm(BaseParameters(*values), viscous_friction),
        viscous_friction,
        plant[..., PLANT["joint_inverse_weight"]],
        plant[..., 12],
        timestep,
    )


@cache
def arm_source(timestep: float) -> str:
    """The C source of simulations with a duration of steps [s]."""
    functions = [c_function(_with_turns(function)) for function in arm_functions(timestep).values()]
    texts = [Path(__file__).with_name(name).read_text(encoding="utf-8") for name in _HAND_WRITTEN]
    return "\n".join(["#include <string.h>", PREAMBLE, _SIZES, solver_functions(), *functions, *texts])


@cache
def arm_functions(timestep: float) -> Mapping[str, SymbolicFunction]:
    """The traced formulas of an arm by name, without the prefix `prp_` of their C functions.

    Args:
        timestep: duration of a step [s].
    """
    return {
        name: trace(f"prp_{name}", formula, shapes) for name, (formula, shapes) in _formulas(timestep).items()
    }


def _with_turns(function: SymbolicFunction) -> SymbolicFunction:
    """The function with another argument instead of the sines and cosines of joints, if it has any."""
    used = []

    def replace(graph: Graph, node: Node, arguments: tuple[Node, ...]) -> Node | None:
        if node.operation not in (SINE, COSINE):
            return None
        used.append(f"{node.operation.name}({arguments[0].name})")
        return graph.input(f"turns[{_TURNS.index(used[-1])}]")

    new = rewritten(function, function.name, replace)
    if not used:
        return function
    graph = next(iter(new.inputs.values())).graph
    turns = SymbolicArray.inputs(graph, "turns", (TURNS_SIZE,))
    return SymbolicFunction(function.name, {**new.inputs, "turns": turns}, new.outputs)


def solver_functions() -> str:
    """The functions that the constraint solver takes from the formulas."""

    def solve(matrix: Any, right: Any) -> Mapping[str, Any]:
        return {"solution": solve_symmetric(matrix, right)}

    return c_function(trace("prp_solve3", solve, {"matrix": (3, 3), "right": (3,)}))


def _formulas(timestep: float) -> dict[str, tuple[Callable[..., Mapping[str, Any]], dict[str, Any]]]:
    """The formulas by name, with the shapes of their arguments."""
    plants = {"plant": (PLANT_SIZE,)}
    surface = {"surface": (SURFACE_SIZE,)}
    row = {"along": (3,), "reference": (1,), "weight": (1,)}

    def unconstrained(q: Any, velocity: Any, torque: Any, plant: Any) -> Mapping[str, Any]:
        B, b = closed_form(plant, timestep).unconstrained(q, velocity, torque)
        return {"B": B, "b": b}

    def friction_rows(q: Any, velocity: Any, plant: Any) -> Mapping[str, Any]:
        return _rows(closed_form(plant, timestep).friction_rows(q, velocity))

    def stop_rows(q: Any, velocity: Any, plant: Any) -> Mapping[str, Any]:
        return _rows(closed_form(plant, timestep).stop_rows(q, velocity))

    def surface_row(q: Any, velocity: Any, plant: Any, surface: Any) -> Mapping[str, Any]:
        rows = closed_form(plant, timestep).surface_row(q, velocity, _surface(surface))
        return {"along": rows.jacobian[0], "reference": rows.reference, "weight": rows.weight}

    def force(B: Any, b: Any, along: Any, reference: Any, weight: Any) -> Mapping[str, Any]:
        return {"push": surface_force(B, b, Rows(along[None], reference, weight))}

    def advanced(q: Any, velocity: Any, plant: Any, B: Any, b: Any) -> Mapping[str, Any]:
        later, faster = closed_form(plant, timestep).advanced(q, velocity, B, b)
        return {"later": later, "faster": faster}

    def measured(q: Any, velocity: Any) -> Mapping[str, Any]:
        arm = PRPArm(NOMINAL)
        pose, rate = arm.forward_kinematics(q), apply(arm.analytical_jacobian(q), velocity)
        return {"measured": np.concatenate([q, velocity, pose, rate], axis=-1)}

    def beyond(q: Any) -> Mapping[str, Any]:
        low, high = np.array(NOMINAL.joint_lower), np.array(NOMINAL.joint_upper)
        return {"beyond": np.minimum(np.minimum(q - low, high - q), 0.0)}

    def plant(mass_factor: Any, viscous_friction: Any, coulomb_friction: Any) -> Mapping[str, Any]:
        return {"plant": plant_row(mass_factor, viscous_friction, coulomb_friction)}

    return {
        "unconstrained": (unconstrained, {**_STATE, "torque": (3,), **plants}),
        "friction_rows": (friction_rows, {**_STATE, **plants}),
        "stop_rows": (stop_rows, {**_STATE, **plants}),
        "surface_row": (surface_row, {**_STATE, **plants, **surface}),
        "surface_force": (force, {**_FORCES, **row}),
        "advanced": (advanced, {**_STATE, **plants, **_FORCES}),
        "measured": (measured, _STATE),
        "beyond": (beyond, {"q": (3,)}),
        "plant_row": (plant, {"mass_factor": (3,), "viscous_friction": (3,), "coulomb_friction": (3,)}),
    }


def _rows(rows: Rows) -> Mapping[str, Any]:
    return {"jacobian": rows.jacobian, "reference": rows.reference, "weight": rows.weight}


def _surface(surface: Any) -> SurfaceRows:
    return SurfaceRows(
        surface[..., 0],
        surface[..., 1],
        surface[..., SURFACE["point"]],
        surface[..., SURFACE["velocity"]],
        surface[..., SURFACE["normal"]],
    )
