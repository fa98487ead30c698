"""Metrics of the joints' motion relative to a desired one, for any number of joints up to three."""

import numpy as np

from prp_gym.evaluation.column import Column
from prp_gym.evaluation.metric import JointMetric, Metric, MetricGroup, Presentation
from prp_gym.evaluation.metrics import register_metric
from prp_gym.evaluation.response import (
    SETTLING_BAND,
    absolute_error,
    is_constant,
    maximum_error,
    mean_absolute_error,
    root_mean_square_error,
    steady_state_error,
    time_inside_for_good,
)
from prp_gym.evaluation.rollout import Rollout
from prp_gym.robot.arrays import Array, norm
from prp_gym.tasks.settling.displacements import JOINT_CENTIMETRE

JOINT_MOTION = MetricGroup("Joint motion", 6.0)

RESOLUTION = np.array([2e-3, 2e-4, 2e-3])
"""Smallest step and band that are evaluated [rad, m, rad]; smaller motions of a joint count as rest."""


def settling_time(time: Array, actual: Array, desired: Array) -> Array:
    """When every joint has entered its band for good.

    The band is 2 % of the joint's step from start to goal, and at least `RESOLUTION`.

    Args:
        time: (T) [s].
        actual: (..., T, joints) [rad, m, rad].
        desired: (..., T, joints).

    Returns:
        (...) [s]; infinite if a joint is outside at the end, NaN if the reference moves.

    Source: the settling time of step responses, with a floor under the band.
    """
    step = np.abs(desired[..., -1, :] - actual[..., 0, :])
    band = np.maximum(SETTLING_BAND * step, RESOLUTION[: step.shape[-1]])
    outside = (absolute_error(actual, desired) > band[..., None, :]).any(axis=-1)
    return np.where(is_constant(desired), time_inside_for_good(time, outside), np.nan)


def overshoot(actual: Array, desired: Array) -> Array:
    """Largest excess of the joints beyond their goals, as a share of the whole move.

    Excess and move are displacements of the tip: each is the norm over the joints, of which each counts as
    much as it moves the tip. A joint that hardly moves cannot dominate the others.

    Args:
        actual: (..., T, joints) [rad, m, rad].
        desired: (..., T, joints).

    Returns:
        (...) [%]; NaN if the reference moves or no joint has a step above `RESOLUTION`. Joints without such
        a step have no excess.

    Source: the overshoot of step responses.
    """
    joints = desired.shape[-1]
    step = desired[..., -1, :] - actual[..., 0, :]
    moves = np.abs(step) > RESOLUTION[:joints]
    direction = np.where(moves, np.sign(step), 0.0) / np.array(JOINT_CENTIMETRE[:joints])
    excess = np.maximum((actual - desired[..., -1:, :]) * direction[..., None, :], 0.0)
    move = norm(step * direction)
    defined = is_constant(desired) & moves.any(axis=-1)
    share = norm(excess).max(axis=-1) / np.where(defined, move, 1.0)
    return np.where(defined, 100.0 * share, np.nan)


def _joints(rollout: Rollout) -> tuple[Array, Array]:
    return rollout.fields["joint_position"], rollout.fields["desired_joint_position"]


_FIELDS = ("joint_position", "desired_joint_position")
_UNITS = ("rad", "m", "rad")

register_metric(
    JointMetric(
        "joint_rmse",
        _UNITS,
        "root mean square of each joint's tracking error",
        _FIELDS,
        lambda r: root_mean_square_error(*_joints(r)),
        Presentation(
            JOINT_MOTION, Column("joint RMSE", ("mrad", "mm", "mrad"), 1e3), "root mean square tracking error"
        ),
    )
)
register_metric(
    JointMetric(
        "joint_mean_error",
        _UNITS,
        "mean over time of each joint's absolute tracking error",
        _FIELDS,
        lambda r: mean_absolute_error(*_joints(r)),
        Presentation(JOINT_MOTION, known_as="mean absolute error; times the duration, IAE"),
    )
)
register_metric(
    JointMetric(
        "joint_maximum_error",
        _UNITS,
        "largest absolute tracking error of each joint",
        _FIELDS,
        lambda r: maximum_error(*_joints(r)),
        Presentation(JOINT_MOTION, known_as="peak tracking error"),
    )
)
register_metric(
    Metric(
        "settling_time",
        ("s",),
        "when every joint is within 2 % of its step (at least 2 mrad, 0.2 mm) for good; constant references",
        _FIELDS,
        lambda r: settling_time(r.time, *_joints(r)),
        Presentation(JOINT_MOTION, Column("set\u00adtling time", ("s",)), "settling time of a step response"),
    )
)
register_metric(
    Metric(
        "overshoot",
        ("%",),
        "largest excess of the joints beyond their goals over the length of the whole move, both norms over"
        " the joints as they move the tip (0.02 rad, 0.01 m, 0.042 rad: 1 cm); joints with a step above"
        " 2 mrad, 0.2 mm; constant references",
        _FIELDS,
        lambda r: overshoot(*_joints(r)),
        Presentation(JOINT_MOTION, Column("over\u00adshoot", ("%",)), "overshoot of a step response"),
        revision=2,
    )
)
register_metric(
    JointMetric(
        "steady_state_error",
        _UNITS,
        "mean error of each joint over the last tenth; on references that rest there",
        _FIELDS,
        lambda r: steady_state_error(*_joints(r)),
        Presentation(
            JOINT_MOTION, Column("steady-state error", ("mrad", "mm", "mrad"), 1e3), "steady-state error"
        ),
    )
)
