"""Metrics of contact tasks: the tracking of the desired force, the contact, and the injected energy.

Forces are by the tip on the surface, in the world frame [N].
"""

import numpy as np
from numpy.typing import NDArray

from prp_gym.evaluation.column import Column
from prp_gym.evaluation.metric import Metric, MetricGroup, Presentation
from prp_gym.evaluation.metrics import register_metric
from prp_gym.evaluation.response import (
    SETTLING_BAND,
    absolute_error,
    is_constant,
    mean_absolute_error,
    root_mean_square_error,
    steady_state_error,
    time_inside_for_good,
)
from prp_gym.evaluation.rollout import Rollout
from prp_gym.physics.surface import CONTACT_THRESHOLD
from prp_gym.robot.arrays import Array, norm
from prp_gym.robot.shared import shared
from prp_gym.tasks.settling.directions import across_desired, along_desired, magnitude

DESIRED_FORCE = MetricGroup("Desired force", 14.0)
CONTACT = MetricGroup("Contact", 15.0)


@shared
def in_contact(force: Array) -> NDArray[np.bool_]:
    """(..., T, 3) [N] -> (..., T), whether the tip touches the surface: `CONTACT_THRESHOLD` exceeded."""
    touches: NDArray[np.bool_] = magnitude(force) > CONTACT_THRESHOLD
    return touches


def mean_deviation_across(actual: Array, desired: Array, force: Array) -> Array:
    """Mean over time of the tip's distance to the desired position, measured across the desired force.

    Pressing moves the tip along the force; what is left lies in the plane in which the position is kept.

    Args:
        actual: (..., T, 3) of the tip [m].
        desired: (..., T, 3) [m].
        force: desired, (..., T, 3) [N].

    Returns:
        (...) [m]; NaN where no force is desired.

    Source: [S] 9.4, the directions of force and of motion.
    """
    across = across_desired(desired - actual, force)
    mean: Array = norm(across).mean(axis=-1)
    return mean


@shared
def _is_force_step(desired: Array) -> NDArray[np.bool_]:
    is_desired: NDArray[np.bool_] = (desired[..., 0, :] != 0.0).any(axis=-1)
    return is_desired & is_constant(desired)


def force_settling_time(time: Array, force: Array, desired: Array) -> Array:
    """How long after the first touch the force enters its band, 2 % of the desired force, for good.

    Args:
        time: (T) [s].
        force: (..., T, 3) [N].
        desired: (..., T, 3) [N].

    Returns:
        (...) [s]; infinite if the force is outside at the end or the tip never touches, NaN if the
        desired force changes or is zero.

    Source: the settling time of step responses.
    """
    actual, goal = along_desired(force, desired)
    outside = absolute_error(actual, goal) > SETTLING_BAND * goal
    touches = in_contact(force)
    settled = time_inside_for_good(time, outside[..., 0]) - time[np.argmax(touches, axis=-1)]
    settled = np.where(touches.any(axis=-1), settled, np.inf)
    return np.where(_is_force_step(desired), settled, np.nan)


def force_overshoot(force: Array, desired: Array) -> Array:
    """Largest excess of the force over the desired one, as a share of it.

    Args:
        force: (..., T, 3) [N].
        desired: (..., T, 3) [N].

    Returns:
        (...) [%], 0 without contact; NaN if the desired force changes or is zero.

    Source: the overshoot of step responses.
    """
    defined = _is_force_step(desired)
    actual, goal = along_desired(force, desired)
    excess = np.maximum((actual - goal).max(axis=(-2, -1)), 0.0)
    return np.where(defined, 100.0 * excess / np.where(defined, goal[..., 0, 0], 1.0), np.nan)


def peak_force(force: Array) -> Array:
    """Largest norm of the contact force over time: (..., T, 3) -> (...) [N]."""
    largest: Array = magnitude(force).max(axis=-1)
    return largest


def contact_losses(force: Array) -> Array:
    """Number of times that the tip leaves the surface after a contact: (..., T, 3) [N] -> (...)."""
    touches = in_contact(force)
    losses: Array = (touches[..., :-1] & ~touches[..., 1:]).sum(axis=-1).astype(np.float64)
    return losses


def injected_energy(force: Array, desired_velocity: Array, velocity: Array, period: float) -> Array:
    """Energy that the controlled arm gave away at its tip beyond what it had received there.

    The power P = h_eᵀ(ẋ_d - ẋ) flows into the arm at the tip, relative to the moving reference. With
    E(t) = ∫ P dt by the trapezoidal rule, the result is max(0, -min E). A target impedance
    M x̃¨ + K_D x̃˙ + K_P x̃ = h_e that starts at rest with x̃ = 0 has E(t) >= 0 and injects nothing; one
    that starts elsewhere may return the energy that its spring held then.

    Args:
        force: (..., T, 3) by the tip on the surface, h_e [N].
        desired_velocity: (..., T, 3) of the tip [m/s].
        velocity: (..., T, 3) of the tip [m/s].
        period: control period [s].

    Returns:
        (...) [J], at least 0.

    Source: Hannaford 2002, the passivity observer.
    """
    power = (force * (desired_velocity - velocity)).sum(axis=-1)
    energy = np.cumsum((power[..., :-1] + power[..., 1:]) / 2, axis=-1) * period
    injected: Array = np.maximum(0.0, -energy.min(axis=-1))
    return injected


def peak_force_ratio(force: Array, desired: Array) -> Array:
    """Largest norm of the contact force over the desired force.

    Args:
        force: (..., T, 3) [N].
        desired: (..., T, 3) [N].

    Returns:
        (...) [%]; NaN if the desired force changes or is zero.
    """
    defined = _is_force_step(desired)
    goal = np.sqrt((desired[..., 0, :] ** 2).sum(axis=-1))
    return np.where(defined, 100.0 * peak_force(force) / np.where(defined, goal, 1.0), np.nan)


def _forces(rollout: Rollout) -> tuple[Array, Array]:
    return rollout.fields["contact_force"], rollout.fields["desired_force"]


def _injected_energy(rollout: Rollout) -> Array:
    fields = rollout.fields
    desired, actual = fields["desired_velocity"][..., :3], fields["end_effector_velocity"][..., :3]
    return injected_energy(fields["contact_force"], desired, actual, rollout.period)


def _deviation_across(rollout: Rollout) -> Array:
    fields = rollout.fields
    actual, desired = fields["end_effector_pose"][..., :3], fields["desired_pose"][..., :3]
    return mean_deviation_across(actual, desired, fields["desired_force"])


_FIELDS = ("contact_force", "desired_force")

register_metric(
    Metric(
        "force_rmse",
        ("N",),
        "root mean square of the force error along the desired force",
        _FIELDS,
        lambda r: root_mean_square_error(*along_desired(*_forces(r))),
        Presentation(DESIRED_FORCE, Column("force RMSE", ("N",)), "root mean square tracking error"),
    )
)
register_metric(
    Metric(
        "force_mean_error",
        ("N",),
        "mean over time of the absolute force error along the desired force",
        _FIELDS,
        lambda r: mean_absolute_error(*along_desired(*_forces(r))),
        Presentation(DESIRED_FORCE, known_as="mean absolute error; times the duration, IAE"),
    )
)
register_metric(
    Metric(
        "surface_mean_error",
        ("m",),
        "mean over time of the tip's distance to the desired position, across the desired force",
        ("end_effector_pose", "desired_pose", "desired_force"),
        lambda r: _deviation_across(r),
        Presentation(DESIRED_FORCE, known_as="mean absolute error; times the duration, IAE"),
    )
)
register_metric(
    Metric(
        "steady_state_force_error",
        ("N",),
        "mean over the last tenth of the desired force less the force along it; where it is constant there",
        _FIELDS,
        lambda r: steady_state_error(*along_desired(*_forces(r))),
        Presentation(DESIRED_FORCE, Column("final force error", ("N",)), "steady-state error"),
    )
)
register_metric(
    Metric(
        "force_settling_time",
        ("s",),
        "from the first touch until the force along the desired one is within 2 % of it for good;"
        " constant desired forces",
        _FIELDS,
        lambda r: force_settling_time(r.time, *_forces(r)),
        Presentation(
            DESIRED_FORCE, Column("force set\u00adtling time", ("s",)), "settling time of a step response"
        ),
    )
)
register_metric(
    Metric(
        "force_overshoot",
        ("%",),
        "largest excess of the force along the desired one over it; constant desired forces",
        _FIELDS,
        lambda r: force_overshoot(*_forces(r)),
        Presentation(DESIRED_FORCE, known_as="overshoot of a step response"),
    )
)
register_metric(
    Metric(
        "peak_force_ratio",
        ("%",),
        "largest norm of the contact force, as a share of the desired force; constant desired forces",
        _FIELDS,
        lambda r: peak_force_ratio(*_forces(r)),
        Presentation(DESIRED_FORCE, Column("force over\u00adshoot", ("%",))),
    )
)

register_metric(
    Metric(
        "peak_force",
        ("N",),
        "largest norm of the contact force",
        ("contact_force",),
        lambda r: peak_force(r.fields["contact_force"]),
        Presentation(CONTACT, Column("peak force", ("N",))),
    )
)
register_metric(
    Metric(
        "contact_losses",
        ("1",),
        "number of times that the tip leaves the surface (force at most 1e-6 N) after a contact, including"
        " intended retreats",
        ("contact_force",),
        lambda r: contact_losses(r.fields["contact_force"]),
        Presentation(CONTACT, Column("con\u00adtacts lost", ("1",))),
    )
)
register_metric(
    Metric(
        "force_violation",
        ("%",),
        "share of steps at which the norm of the contact force is beyond the task's bound",
        ("cost_force_bound",),
        lambda r: 100.0 * r.info["cost_force_bound"].mean(),
        Presentation(CONTACT),
    )
)
register_metric(
    Metric(
        "injected_energy",
        ("J",),
        "max(0, -min E) of E(t) = ∫ h_eᵀ(ẋ_d - ẋ) dt: energy that the arm gave away at its tip, relative"
        " to its moving reference, beyond what it had received there; 0 for a passive arm that starts"
        " at rest; on tasks with a target model, since a desired force asks for work on the surface",
        ("contact_force", "desired_velocity", "end_effector_velocity", "model_pose"),
        lambda r: _injected_energy(r),
        Presentation(
            CONTACT, Column("in\u00adjected energy", ("mJ",), 1e3), "passivity observer (Hannaford 2002)"
        ),
        revision=2,
    )
)
