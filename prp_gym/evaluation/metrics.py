"""Metrics of an episode: pure functions of what was recorded, each declared with unit and source.

Time runs along the second-to-last axis; every function broadcasts over the dimensions before it. Values
that do not exist for an episode (a settling time on a moving reference) are NaN; a settling time that
was not reached is infinite.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from prp_gym.evaluation.rollout import Rollout
from prp_gym.robot.arrays import Array

SETTLING_BAND = 0.02
RESOLUTION = np.array([2e-3, 2e-4, 2e-3])
"""Smallest step and band that count [rad, m, rad]: below them a joint is taken to stand still."""

_FINAL_PART = 0.1


def root_mean_square_error(actual: Array, desired: Array) -> Array:
    """√(mean over time of the squared error).

    Args:
        actual: (..., T, d).
        desired: (..., T, d), same units.

    Returns:
        (..., d), same units.
    """
    error: Array = np.sqrt(np.mean((desired - actual) ** 2, axis=-2))
    return error


def maximum_error(actual: Array, desired: Array) -> Array:
    """Largest absolute error over time; arguments as in `root_mean_square_error`."""
    error: Array = np.abs(desired - actual).max(axis=-2)
    return error


def is_constant(desired: Array) -> NDArray[np.bool_]:
    """(...), whether a reference (..., T, d) never moves."""
    still: NDArray[np.bool_] = np.logical_and.reduce(desired == desired[..., :1, :], axis=(-2, -1))
    return still


def settling_time(time: Array, actual: Array, desired: Array) -> Array:
    """When every joint has entered its band for good.

    The band is 2 % of the joint's step from start to goal, and at least `RESOLUTION`.

    Args:
        time: (T) [s].
        actual: (..., T, 3) [rad, m, rad].
        desired: (..., T, 3).

    Returns:
        (...) [s]; infinite if a joint is outside at the end, NaN if the reference moves.

    Source: the settling time of step responses, with a floor under the band.
    """
    step = np.abs(desired[..., -1, :] - actual[..., 0, :])
    band = np.maximum(SETTLING_BAND * step, RESOLUTION)
    outside = (np.abs(desired - actual) > band[..., None, :]).any(axis=-1)
    count = outside.shape[-1]
    last_outside = count - 1 - np.argmax(outside[..., ::-1], axis=-1)
    reached = np.where(outside.any(axis=-1), last_outside + 1, 0)
    settled = np.append(time, np.inf)[reached]
    return np.where(is_constant(desired), settled, np.nan)


def overshoot(actual: Array, desired: Array) -> Array:
    """Largest excess beyond the goal over all joints, as a share of the joint's step.

    Args:
        actual: (..., T, 3) [rad, m, rad].
        desired: (..., T, 3).

    Returns:
        (...) [%]; NaN if the reference moves or no joint has a step above `RESOLUTION`.

    Source: the overshoot of step responses.
    """
    step = desired[..., -1, :] - actual[..., 0, :]
    moves = np.abs(step) > RESOLUTION
    excess = ((actual - desired[..., -1:, :]) * np.sign(step)[..., None, :]).max(axis=-2)
    share = np.where(moves, np.maximum(excess, 0.0) / np.where(moves, np.abs(step), 1.0), 0.0)
    defined = is_constant(desired) & moves.any(axis=-1)
    return np.where(defined, 100.0 * share.max(axis=-1), np.nan)


def steady_state_error(actual: Array, desired: Array) -> Array:
    """Mean error over the last tenth of the episode.

    Args:
        actual: (..., T, d).
        desired: (..., T, d).

    Returns:
        (..., d), signed (desired - actual); NaN if the reference moves in that part.
    """
    final = max(1, round(_FINAL_PART * actual.shape[-2]))
    error = np.mean(desired[..., -final:, :] - actual[..., -final:, :], axis=-2)
    still = is_constant(desired[..., -final:, :])
    return np.where(still[..., None], error, np.nan)


def mechanical_energy(torque: Array, velocity: Array, period: float) -> Array:
    """∫ Σ |τ_i q̇_i| dt by the trapezoidal rule over each control period, the applied torque held.

    Args:
        torque: (..., T, 3) [N m, N, N m].
        velocity: (..., T + 1, 3) joint velocities [rad/s, m/s, rad/s].
        period: of control [s].

    Returns:
        (...) [J].
    """
    before, after = np.abs(velocity[..., :-1, :]), np.abs(velocity[..., 1:, :])
    work: Array = (np.abs(torque) * (before + after) / 2).sum(axis=(-2, -1)) * period
    return work


def root_mean_square(values: Array) -> Array:
    """√(mean over time of the squares): (..., T, d) -> (..., d), same units."""
    mean: Array = np.sqrt(np.mean(values**2, axis=-2))
    return mean


def torque_rate(torque: Array, period: float) -> Array:
    """Root mean square of the torque's change per second: (..., T, 3) -> (..., 3) [N m/s, N/s, N m/s].

    NaN where there is one step only.
    """
    if torque.shape[-2] < 2:
        return np.full((*torque.shape[:-2], torque.shape[-1]), np.nan)
    return root_mean_square(np.diff(torque, axis=-2) / period)


@dataclass(frozen=True)
class Metric:
    """A declared metric of an episode.

    Attributes:
        name: in results and tables.
        units: one a component.
        definition: one sentence.
        requires: observation fields without which it does not exist.
        compute: from a recorded episode, as many numbers as units.
        higher_is_better: the direction.
        survives_divergence: whether it means something for an episode that was cut short.
    """

    name: str
    units: tuple[str, ...]
    definition: str
    requires: tuple[str, ...]
    compute: Callable[[Rollout], Array]
    higher_is_better: bool = False
    survives_divergence: bool = False


def _joints(rollout: Rollout) -> tuple[Array, Array]:
    return rollout.fields["joint_position"], rollout.fields["desired_joint_position"]


_JOINT_FIELDS = ("joint_position", "desired_joint_position")
_JOINT_UNITS = ("rad", "m", "rad")

METRICS = (
    Metric(
        "score",
        ("1",),
        "return over duration, in [0, 1]; what is lost after a divergence counts as 0",
        (),
        lambda r: np.array([r.reward.sum() / r.duration]),
        higher_is_better=True,
        survives_divergence=True,
    ),
    Metric(
        "joint_rmse",
        _JOINT_UNITS,
        "root mean square of each joint's tracking error",
        _JOINT_FIELDS,
        lambda r: root_mean_square_error(*_joints(r)),
    ),
    Metric(
        "joint_maximum_error",
        _JOINT_UNITS,
        "largest absolute tracking error of each joint",
        _JOINT_FIELDS,
        lambda r: maximum_error(*_joints(r)),
    ),
    Metric(
        "settling_time",
        ("s",),
        "when every joint is within 2 % of its step (at least 2 mrad, 0.2 mm) for good; constant references",
        _JOINT_FIELDS,
        lambda r: np.atleast_1d(settling_time(r.time, *_joints(r))),
    ),
    Metric(
        "overshoot",
        ("%",),
        "largest excess beyond the goal over a joint's step (above 2 mrad, 0.2 mm); constant references",
        _JOINT_FIELDS,
        lambda r: np.atleast_1d(overshoot(*_joints(r))),
    ),
    Metric(
        "steady_state_error",
        _JOINT_UNITS,
        "mean error of each joint over the last tenth; on references that rest there",
        _JOINT_FIELDS,
        lambda r: steady_state_error(*_joints(r)),
    ),
    Metric(
        "energy",
        ("J",),
        "∫ Σ |τ_i q̇_i| dt of the torques that acted",
        ("joint_velocity",),
        lambda r: np.atleast_1d(mechanical_energy(r.applied_torque, r.fields["joint_velocity"], r.period)),
    ),
    Metric(
        "torque_rms",
        ("N·m", "N", "N·m"),
        "root mean square of each commanded torque",
        (),
        lambda r: root_mean_square(r.torque),
    ),
    Metric(
        "torque_rate",
        ("N·m/s", "N/s", "N·m/s"),
        "root mean square of each commanded torque's change per second",
        (),
        lambda r: torque_rate(r.torque, r.period),
    ),
    Metric(
        "saturation",
        ("%",),
        "share of joints and steps at or beyond the actuator limit",
        (),
        lambda r: np.array([100.0 * r.info["cost_saturation"].mean() / 3]),
    ),
    Metric(
        "joint_stop",
        ("%",),
        "share of joints and steps beyond a joint stop",
        (),
        lambda r: np.array([100.0 * r.info["cost_joint_stop"].mean() / 3]),
    ),
    Metric(
        "divergence",
        ("%",),
        "share of episodes that ended in a divergence",
        (),
        lambda r: np.array([100.0 * r.diverged]),
        survives_divergence=True,
    ),
)


def episode_metrics(rollout: Rollout) -> dict[str, Array]:
    """Every metric that exists for an episode, by name.

    After a divergence only the score and the divergence mean anything; the others are NaN.
    """
    return {
        metric.name: np.full(len(metric.units), np.nan)
        if rollout.diverged and not metric.survives_divergence
        else metric.compute(rollout)
        for metric in METRICS
        if all(name in rollout.fields for name in metric.requires)
    }
