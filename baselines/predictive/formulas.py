"""The formulas of an iteration by name, as they are traced into compiled code and as NumPy evaluates them."""

from collections.abc import Callable, Mapping
from functools import cache, lru_cache
from pathlib import Path
from typing import Any, NamedTuple

from prp_gym.baselines.base.control_interface import Model
from prp_gym.baselines.predictive.knots import (
    WEIGHTS,
    Knot,
    backward_step,
    cost_curvature,
    cost_slope,
    followed_torque,
    knot_cost,
    knot_motion,
)
from prp_gym.symbolic.c_source import PREAMBLE, c_function
from prp_gym.symbolic.derivatives import jacobian
from prp_gym.symbolic.function import SymbolicFunction, trace

KNOTS = 16
"""Number of intervals of a plan."""

Formula = Callable[..., Mapping[str, Any]]
Shapes = dict[str, tuple[int, ...]]


class Motion:
    """`knot_motion` of a model.

    Args:
        model: nominal robot.
    """

    def __init__(self, model: Model) -> None:
        self._model = model

    def __call__(self, position: Any, velocity: Any, torque: Any, duration: Any) -> dict[str, Any]:
        """The state at the end of an interval."""
        later, faster = knot_motion(self._model, position, velocity, torque, duration)
        return {"later": later, "faster": faster}


def cost(position: Any, velocity: Any, torque: Any, **knot: Any) -> dict[str, Any]:
    """`knot_cost`."""
    return {"cost": knot_cost(position, velocity, torque, Knot(**knot))}


def follow(
    torque: Any, change: Any, gain: Any, share: Any, deviation: Any, low: Any, high: Any
) -> dict[str, Any]:
    """`followed_torque` with a share (..., 1) of the change."""
    return {"followed": followed_torque(torque, (share * change, gain), deviation, (low, high))}


def backward(
    position: Any,
    velocity: Any,
    torque: Any,
    by_position: Any,
    by_velocity: Any,
    by_torque: Any,
    duration: Any,
    slope_after: Any,
    curvature_after: Any,
    low: Any,
    high: Any,
    **knot: Any,
) -> dict[str, Any]:
    """`backward_step` about the state at the end of an interval, with the cost of the later ones."""
    own = Knot(**knot)
    to_go = (
        slope_after + cost_slope(position, velocity, own),
        curvature_after + cost_curvature(position, velocity, own),
    )
    effort = torque - own.effort, own.effort_weight
    derivatives = by_position, by_velocity, by_torque
    return backward_step(derivatives, duration, to_go, effort, (low - torque, high - torque))._asdict()


class Functions(NamedTuple):
    """The traced formulas of a model."""

    motion: SymbolicFunction
    derivatives: SymbolicFunction
    cost: SymbolicFunction
    follow: SymbolicFunction
    backward: SymbolicFunction


@lru_cache(maxsize=16)
def functions_of(model: Model) -> Functions:
    """The traced formulas of a model; derivatives are those of the velocity at the end of an interval."""
    n = model.joint_count
    state: Shapes = {"position": (n,), "velocity": (n,), "torque": (n,)}
    knot: Shapes = {
        "desired": (2 * n,),
        "weight": (WEIGHTS * n,),
        "threshold": (n,),
        "effort": (n,),
        "effort_weight": (n,),
        "stops": (2 * n,),
        "stop_weight": (n,),
    }
    bounds: Shapes = {"low": (n,), "high": (n,)}
    around: Shapes = {f"by_{name}": (n, n) for name in state} | {"duration": (1,)}
    after: Shapes = {"slope_after": (2 * n,), "curvature_after": (2 * n, 2 * n)}
    step: Shapes = {"torque": (n,), "change": (n,), "gain": (n, 2 * n), "share": (1,), "deviation": (2 * n,)}
    motion = trace("prp_motion", Motion(model), {**state, "duration": (1,)})
    faster = motion.outputs["faster"]
    by = {f"by_{name}": jacobian(faster, motion.inputs[name]) for name in state}
    return Functions(
        motion,
        SymbolicFunction("prp_motion_derivatives", motion.inputs, by),
        trace("prp_cost", cost, {**state, **knot}),
        trace("prp_follow", follow, {**step, **bounds}),
        trace("prp_backward", backward, {**state, **around, **after, **bounds, **knot}),
    )


@lru_cache(maxsize=16)
def source_of(model: Model) -> str:
    """The C source of `prp_improve`."""
    sizes = f"#include <string.h>\n#define PRP_JOINTS {model.joint_count}\n#define PRP_KNOTS {KNOTS}\n"
    return "\n".join([PREAMBLE, sizes, *(c_function(each) for each in functions_of(model)), _loop()])


@cache
def _loop() -> str:
    return Path(__file__).with_name("iteration.c").read_text(encoding="utf-8")
