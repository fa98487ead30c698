"""Metrics of the tip's motion relative to a desired pose, and to the pose of a reference model.

A pose is (p, α, β, γ) [m, rad] in the world frame. Orientation errors are the norm over α and β: γ is
the same in every configuration of the arm. Angles are not wrapped: α and β are joint angles up to
a sign and a constant, and a joint that is one revolution away from its goal has not reached it.
"""

import numpy as np

from prp_gym.evaluation.column import Column
from prp_gym.evaluation.metric import Metric, MetricGroup, Presentation
from prp_gym.evaluation.metrics import register_metric
from prp_gym.evaluation.response import (
    SETTLING_BAND,
    distance,
    is_constant,
    maximum_distance,
    mean_distance,
    root_mean_square_distance,
    steady_state_error,
    time_inside_for_good,
)
from prp_gym.evaluation.rollout import Rollout
from prp_gym.robot.arrays import Array
from prp_gym.robot.shared import shared

TIP_MOTION = MetricGroup("Tip motion", 9.0)
REFERENCE_MODEL = MetricGroup("Reference model", 11.0)

POSITION_RESOLUTION = 2e-4
"""Smallest step and band that are evaluated [m]; smaller motions of the tip count as rest."""

_POSITION = slice(0, 3)
_ORIENTATION = slice(3, 5)


def position_settling_time(time: Array, actual: Array, desired: Array) -> Array:
    """When the tip has come within its band around the goal for good.

    The band is 2 % of the distance from start to goal, and at least `POSITION_RESOLUTION`.

    Args:
        time: (T) [s].
        actual: (..., T, 3) [m].
        desired: (..., T, 3) [m].

    Returns:
        (...) [s]; infinite if the tip is outside at the end, NaN if the reference moves.

    Source: ISO 9283, position stabilization time, with the band of step responses.
    """
    error = distance(actual, desired)
    band = np.maximum(SETTLING_BAND * error[..., 0], POSITION_RESOLUTION)
    settled = time_inside_for_good(time, error > band[..., None])
    return np.where(is_constant(desired), settled, np.nan)


def position_overshoot(actual: Array, desired: Array) -> Array:
    """Largest excess beyond the goal along the line from start to goal, over their distance.

    Args:
        actual: (..., T, 3) [m].
        desired: (..., T, 3) [m].

    Returns:
        (...) [%]; NaN if the reference moves or starts within `POSITION_RESOLUTION` of the tip.

    Source: ISO 9283, position overshoot, relative to the distance as in step responses.
    """
    step = desired[..., 0, :] - actual[..., 0, :]
    square = (step**2).sum(axis=-1)
    defined = is_constant(desired) & (square > POSITION_RESOLUTION**2)
    beyond = ((actual - desired) * step[..., None, :]).sum(axis=-1).max(axis=-1)
    share = np.maximum(beyond, 0.0) / np.where(defined, square, 1.0)
    return np.where(defined, 100.0 * share, np.nan)


def position_steady_state_error(actual: Array, desired: Array) -> Array:
    """Norm of the mean error over the last tenth of the episode.

    Args:
        actual: (..., T, 3) [m].
        desired: (..., T, 3) [m].

    Returns:
        (...) [m]; NaN if the reference moves in that part.

    Source: ISO 9283, positioning accuracy, with a mean over time instead of over repetitions.
    """
    norm: Array = np.sqrt((steady_state_error(actual, desired) ** 2).sum(axis=-1))
    return norm


@shared
def _poses(rollout: Rollout, reference: str, part: slice) -> tuple[Array, Array]:
    return rollout.fields["end_effector_pose"][..., part], rollout.fields[reference][..., part]


def _positions(rollout: Rollout) -> tuple[Array, Array]:
    return _poses(rollout, "desired_pose", _POSITION)


def _orientations(rollout: Rollout) -> tuple[Array, Array]:
    return _poses(rollout, "desired_pose", _ORIENTATION)


_FIELDS = ("end_effector_pose", "desired_pose")
_MODEL_FIELDS = ("end_effector_pose", "model_pose")

register_metric(
    Metric(
        "position_rmse",
        ("m",),
        "root mean square of the tip's distance to the desired position",
        _FIELDS,
        lambda r: root_mean_square_distance(*_positions(r)),
        Presentation(TIP_MOTION, Column("position RMSE", ("mm",), 1e3), "root mean square tracking error"),
    )
)
register_metric(
    Metric(
        "position_mean_error",
        ("m",),
        "mean over time of the tip's distance to the desired position",
        _FIELDS,
        lambda r: mean_distance(*_positions(r)),
        Presentation(TIP_MOTION, known_as="mean absolute error; times the duration, IAE"),
    )
)
register_metric(
    Metric(
        "position_maximum_error",
        ("m",),
        "largest distance of the tip to the desired position",
        _FIELDS,
        lambda r: maximum_distance(*_positions(r)),
        Presentation(TIP_MOTION, known_as="positioning path accuracy (ISO 9283), taken at equal times"),
    )
)
register_metric(
    Metric(
        "orientation_rmse",
        ("rad",),
        "root mean square of the norm of the errors of α and β",
        _FIELDS,
        lambda r: root_mean_square_distance(*_orientations(r)),
        Presentation(TIP_MOTION, Column("angle RMSE", ("mrad",), 1e3), "root mean square tracking error"),
    )
)
register_metric(
    Metric(
        "orientation_mean_error",
        ("rad",),
        "mean over time of the norm of the errors of α and β",
        _FIELDS,
        lambda r: mean_distance(*_orientations(r)),
        Presentation(TIP_MOTION, known_as="mean absolute error; times the duration, IAE"),
    )
)
register_metric(
    Metric(
        "orientation_maximum_error",
        ("rad",),
        "largest norm of the errors of α and β",
        _FIELDS,
        lambda r: maximum_distance(*_orientations(r)),
        Presentation(
            TIP_MOTION,
            known_as="orientation path accuracy (ISO 9283), taken at equal times and over both angles",
        ),
    )
)
register_metric(
    Metric(
        "position_settling_time",
        ("s",),
        "when the tip is within 2 % of its first distance to the goal (at least 0.2 mm) for good;"
        " constant references",
        _FIELDS,
        lambda r: position_settling_time(r.time, *_positions(r)),
        Presentation(
            TIP_MOTION,
            Column("set\u00adtling time", ("s",)),
            "position stabilization time (ISO 9283), with the band of step responses",
        ),
    )
)
register_metric(
    Metric(
        "position_overshoot",
        ("%",),
        "largest excess beyond the goal along the line from start to goal, over their distance"
        " (above 0.2 mm); constant references",
        _FIELDS,
        lambda r: position_overshoot(*_positions(r)),
        Presentation(
            TIP_MOTION,
            Column("over\u00adshoot", ("%",)),
            "position overshoot (ISO 9283), as a share of the distance",
        ),
    )
)
register_metric(
    Metric(
        "position_steady_state_error",
        ("m",),
        "norm of the tip's mean position error over the last tenth; on references that rest there",
        _FIELDS,
        lambda r: position_steady_state_error(*_positions(r)),
        Presentation(
            TIP_MOTION,
            Column("steady-state error", ("mm",), 1e3),
            "positioning accuracy (ISO 9283), with a mean over time instead of over repetitions",
        ),
    )
)

register_metric(
    Metric(
        "model_position_rmse",
        ("m",),
        "root mean square of the tip's distance to the reference model that the contact force drives",
        _MODEL_FIELDS,
        lambda r: root_mean_square_distance(*_poses(r, "model_pose", _POSITION)),
        Presentation(
            REFERENCE_MODEL, Column("error to model, position", ("mm",), 1e3), "model-following error"
        ),
    )
)
register_metric(
    Metric(
        "model_orientation_rmse",
        ("rad",),
        "root mean square of the norm of the differences in α and β to the reference model",
        _MODEL_FIELDS,
        lambda r: root_mean_square_distance(*_poses(r, "model_pose", _ORIENTATION)),
        Presentation(
            REFERENCE_MODEL, Column("error to model, angles", ("mrad",), 1e3), "model-following error"
        ),
    )
)
register_metric(
    Metric(
        "model_position_mean_error",
        ("m",),
        "mean over time of the tip's distance to the reference model",
        _MODEL_FIELDS,
        lambda r: mean_distance(*_poses(r, "model_pose", _POSITION)),
        Presentation(REFERENCE_MODEL, known_as="model-following error"),
    )
)
register_metric(
    Metric(
        "model_orientation_mean_error",
        ("rad",),
        "mean over time of the norm of the differences in α and β to the reference model",
        _MODEL_FIELDS,
        lambda r: mean_distance(*_poses(r, "model_pose", _ORIENTATION)),
        Presentation(REFERENCE_MODEL, known_as="model-following error"),
    )
)
register_metric(
    Metric(
        "model_maximum_error",
        ("m",),
        "largest distance of the tip to the reference model",
        _MODEL_FIELDS,
        lambda r: maximum_distance(*_poses(r, "model_pose", _POSITION)),
        Presentation(REFERENCE_MODEL, known_as="peak model-following error"),
    )
)
