"""Random problems of plans."""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from prp_gym.baselines.predictive.formulas import KNOTS
from prp_gym.baselines.predictive.grid import interval_durations
from prp_gym.baselines.predictive.iteration import Problem
from prp_gym.robot import Link, LinkParameters, PRPArm

Array = NDArray[np.float64]

ARM, LINK = PRPArm(), Link()
WEIGHTLESS = Link(LinkParameters(inertia=0.5, viscous_friction=0.0, gravity_moment=0.0))
"""A double integrator: its plans are exactly linear in their torques."""


def limit_of(model: PRPArm | Link) -> Array:
    return np.array(model.parameters.torque_limit)


def random_problem(model: PRPArm | Link, count: int, seed: int = 1, **changes: Any) -> Problem:
    """Starts and goals within the joint stops, weights of the size of tuned ones."""
    generator, n = np.random.default_rng(seed), model.joint_count
    scale, limit = np.array([1.0, 0.05, 1.0])[:n], limit_of(model)
    duration = interval_durations(0.002, 0.2)
    desired = np.zeros((count, KNOTS, 2 * n))
    desired[..., :n] = generator.uniform(-2.0, 2.0, (count, 1, n)) * scale
    weight = np.zeros((count, KNOTS, 3 * n))
    weight[..., :n] = 1e4 / scale**2 * duration
    weight[..., 2 * n :] = 3.0 / scale**2 * duration
    weight[:, -1] += np.repeat([50.0, 0.5, 0.01], n) / np.tile(scale, 3) ** 2  # positive definite
    state = generator.uniform(-2.0, 2.0, (count, 2 * n)) * np.tile(scale, 2)
    for positions in (state[:, :n], desired[..., :n]):
        positions += [0.0, -0.15, 0.0][:n]
    stops = np.array([-np.inf, np.inf]) if n == 1 else np.concatenate(ARM.joint_limits)
    problem = Problem(
        state=state,
        duration=duration,
        desired=desired,
        weight=weight,
        threshold=weight[..., :n] * (0.1 * scale) ** 2,
        effort=generator.uniform(-0.1, 0.1, (count, KNOTS, n)) * limit,
        effort_weight=duration / limit**2,
        stops=np.repeat(stops[None], KNOTS, axis=0),
        stop_weight=1e5 / scale**2 * duration,
        low=np.broadcast_to(-limit, (count, KNOTS, n)).copy(),
        high=np.broadcast_to(limit, (count, KNOTS, n)).copy(),
    )
    return replace(problem, **changes)


def row_of(problem: Problem, row: int) -> Problem:
    """One plan's problem."""
    own = ("state", "desired", "weight", "threshold", "effort", "low", "high")
    return replace(problem, **{name: getattr(problem, name)[row : row + 1] for name in own})


def random_plan(model: PRPArm | Link, count: int, seed: int = 2) -> Array:
    """Torques (count, N, n) within the limits."""
    size = (count, KNOTS, model.joint_count)
    return np.random.default_rng(seed).uniform(-0.5, 0.5, size) * limit_of(model)
