"""`improve`: one iteration of iterative LQR for plans of any leading dimensions."""

import ctypes
from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from prp_gym.baselines.base.control_interface import Model
from prp_gym.baselines.predictive.formulas import (
    KNOTS,
    Motion,
    backward,
    cost,
    follow,
    functions_of,
    source_of,
)
from prp_gym.baselines.predictive.knots import Knot
from prp_gym.errors import CompilerError, InvalidValueError, NonFiniteError
from prp_gym.robot.arrays import Array
from prp_gym.symbolic.compiler import compiles_by_default, load_library

SHARES = (1.0, 0.5, 0.25, 0.125, 0.0625, 0.03125)
"""Shares of a step that the line search tries; without an improvement the plan stays."""


@dataclass(frozen=True, eq=False)
class Problem:
    """What plans of N intervals, for n joints each, have to minimise.

    Attributes:
        state: q and q̇ (M, 2n) at the start.
        duration: h (N, 1) of the intervals [s].
        desired: q_d and q̇_d (M, N, 2n) at the ends of the intervals.
        weight: W_p, W_m and W_v (M, N, 3n) of the errors there.
        threshold: κ (M, N, n).
        effort: τ_d (M, N, n) [N m, N, N m].
        effort_weight: R (N, n).
        stops: least and greatest position (N, 2n).
        stop_weight: W_s (N, n).
        low: least torque (M, N, n) [N m, N, N m].
        high: greatest torque (M, N, n).
    """

    state: Array
    duration: Array
    desired: Array
    weight: Array
    threshold: Array
    effort: Array
    effort_weight: Array
    stops: Array
    stop_weight: Array
    low: Array
    high: Array


class Improved(NamedTuple):
    """The results of an iteration.

    Attributes:
        torque: torques (M, N, n) of the plans.
        expected: q and q̇ (M, 2n) after their first interval.
        cost: cost before and after (M, 2).
    """

    torque: Array
    expected: Array
    cost: Array


def improve(model: Model, problem: Problem, torque: Array) -> Improved:
    """One iteration, in compiled code where the machine has it for this model, else with NumPy.

    Both have the same bits.

    Args:
        model: nominal robot.
        problem: problem of each plan.
        torque: torques (M, N, n) of the plans.

    Source: Tassa 2014, II and III.
    """
    compiled = compiles_by_default() and _library_of(source_of(model)) is not None
    return (improve_compiled if compiled else improve_with_numpy)(model, problem, torque)


@lru_cache(maxsize=16)
def _library_of(source: str) -> ctypes.CDLL | None:
    """The compiled code; None where there is none.

    So it is for a model of one's own with a wheel whose libraries are those of the nominal one.
    """
    try:
        return load_library(source)
    except CompilerError:
        return None


def improve_compiled(model: Model, problem: Problem, torque: Array) -> Improved:
    """`improve` in compiled code.

    Raises:
        CompilerError: this machine has neither the compiled code nor a compiler.
    """
    count, size = problem.state.shape
    found = Improved(torque.copy(), np.empty((count, size)), np.empty((count, 2)))
    given = [np.ascontiguousarray(getattr(problem, entry.name)) for entry in fields(problem)]
    function = load_library(source_of(model)).prp_improve
    function.restype = None
    function(ctypes.c_long(count), *(ctypes.c_void_p(array.ctypes.data) for array in (*given, *found)))
    return found


class _Plan(NamedTuple):
    """Torques (N, M, n), states (N + 1, M, 2n) from the start on, and the cost (M, 1)."""

    torque: Array
    state: Array
    cost: Array


@np.errstate(all="ignore")
def improve_with_numpy(model: Model, problem: Problem, torque: Array) -> Improved:
    """`improve` with NumPy alone."""
    count, size = problem.state.shape
    knots = _by_knot(problem)
    still = [(np.zeros(torque.shape[::2]), np.zeros((count, size // 2, size)))] * KNOTS
    state = np.broadcast_to(problem.state, (KNOTS + 1, count, size))
    given = _Plan(np.moveaxis(torque, 1, 0), state, np.full((count, 1), np.inf))
    old = best = _forward(model, knots, given, still, 0.0)
    step = _improving_step(model, knots, old)
    for share in SHARES:
        tried = _forward(model, knots, old, step, share)
        better = (tried.cost < old.cost) & (best.cost == old.cost)
        best = _Plan(*(np.where(better, new, own) for new, own in zip(tried, best, strict=True)))
        if (best.cost < old.cost).all():
            break
    costs = np.concatenate([old.cost, best.cost], axis=-1)
    return Improved(np.moveaxis(best.torque, 0, 1), best.state[1], costs)


def _by_knot(problem: Problem) -> list[dict[str, Any]]:
    """The arguments of the formulas for each interval."""
    shared = ("duration", "effort_weight", "stops", "stop_weight")
    own = ("desired", "weight", "threshold", "effort", "low", "high")
    return [
        {name: getattr(problem, name)[k] for name in shared}
        | {name: getattr(problem, name)[:, k] for name in own}
        for k in range(KNOTS)
    ]


def _halves(state: Array) -> dict[str, Array]:
    size = state.shape[-1] // 2
    return {"position": state[..., :size], "velocity": state[..., size:]}


def _taken(knot: dict[str, Any], *names: str) -> dict[str, Any]:
    return {name: knot[name] for name in names}


_COST = Knot._fields


def _forward(
    model: Model, knots: list[dict[str, Any]], old: _Plan, step: list[tuple[Array, Array]], share: float
) -> _Plan:
    """The forward pass: a new plan from an old one and a share of a step."""
    states, torques = [old.state[0]], []
    total = np.zeros((len(old.state[0]), 1))
    for k, knot in enumerate(knots):
        change, gain = step[k]
        torque = follow(
            old.torque[k],
            change,
            gain,
            np.full((1,), share),
            states[k] - old.state[k],
            knot["low"],
            knot["high"],
        )["followed"]
        later = _moved(model, {**_halves(states[k]), "torque": torque}, knot["duration"])
        states.append(np.concatenate([later["later"], later["faster"]], axis=-1))
        total = total + cost(**_halves(states[-1]), torque=torque, **_taken(knot, *_COST))["cost"]
        torques.append(torque)
    return _Plan(np.array(torques), np.array(states), total)


def _moved(model: Model, state: dict[str, Any], duration: Array) -> Mapping[str, Any]:
    """The state at the end of an interval; where a plan diverges, by the graph, which refuses no number."""
    try:
        return Motion(model)(**state, duration=duration)
    except (InvalidValueError, NonFiniteError):
        durations = np.broadcast_to(duration, (len(state["torque"]), 1))
        return functions_of(model).motion.evaluate_rows({**state, "duration": durations})


def _improving_step(model: Model, knots: list[dict[str, Any]], plan: _Plan) -> list[tuple[Array, Array]]:
    """The backward pass: change and gain of each interval."""
    durations = np.array([np.broadcast_to(knot["duration"], (plan.cost.shape)) for knot in knots])
    around = functions_of(model).derivatives.evaluate_rows(
        {**_halves(plan.state[:-1]), "torque": plan.torque, "duration": durations}
    )
    count, size = plan.state.shape[1:]
    slope, curvature = np.zeros((count, size)), np.zeros((count, size, size))
    steps = []
    for k in reversed(range(KNOTS)):
        found = backward(
            **_halves(plan.state[k + 1]),
            torque=plan.torque[k],
            **{name: values[k] for name, values in around.items()},
            slope_after=slope,
            curvature_after=curvature,
            **knots[k],
        )
        slope, curvature = found["slope"], found["curvature"]
        steps.append((found["change"], found["gain"]))
    return steps[::-1]
