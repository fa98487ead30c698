"""Metrics of the effort of a motion: energy, torques, and the limits that are reached."""

import numpy as np

from prp_gym.evaluation.column import Column
from prp_gym.evaluation.metric import JointMetric, Metric, MetricGroup, Presentation
from prp_gym.evaluation.metrics import register_metric
from prp_gym.evaluation.response import root_mean_square
from prp_gym.evaluation.rollout import Rollout
from prp_gym.robot.arrays import Array
from prp_gym.robot.shared import shared

EFFORT = MetricGroup("Effort", 16.0)


@shared
def mechanical_energy(torque: Array, velocity: Array, period: float) -> Array:
    """∫ Σ |τ_i q̇_i| dt by the trapezoidal rule over each control period, the applied torque held.

    Args:
        torque: (..., T, joints) [N m, N, N m].
        velocity: (..., T + 1, joints) joint velocities [rad/s, m/s, rad/s].
        period: control period [s].

    Returns:
        (...) [J].
    """
    before, after = np.abs(velocity[..., :-1, :]), np.abs(velocity[..., 1:, :])
    work: Array = (np.abs(torque) * (before + after) / 2).sum(axis=(-2, -1)) * period
    return work


def excess_energy(torque: Array, velocity: Array, period: float) -> Array:
    """∫ Σ |τ_i q̇_i| dt - |∫ Σ τ_i q̇_i dt|: work that the actuators gave and took back, or gave to each other.

    What is left, the net work, is what gravity, friction, the surface and the final speed have taken.

    Args:
        torque: (..., T, joints) [N m, N, N m].
        velocity: (..., T + 1, joints) joint velocities [rad/s, m/s, rad/s].
        period: control period [s].

    Returns:
        (...) [J], at least 0.
    """
    mean = (velocity[..., :-1, :] + velocity[..., 1:, :]) / 2
    net = np.abs((torque * mean).sum(axis=(-2, -1))) * period
    excess: Array = np.maximum(mechanical_energy(torque, velocity, period) - net, 0.0)
    return excess


def torque_rate(torque: Array, period: float) -> Array:
    """Root mean square of the torque's change per second.

    Args:
        torque: (..., T, joints) [N m, N, N m].
        period: control period [s].

    Returns:
        (..., joints) [N m/s, N/s, N m/s]; NaN where there is one step only.
    """
    if torque.shape[-2] < 2:
        return np.full((*torque.shape[:-2], torque.shape[-1]), np.nan)
    return root_mean_square(np.diff(torque, axis=-2) / period)


def share_of_joints(counts: Array, joints: int) -> Array:
    """Mean over time of the counted joints, as a percentage of all joints: (..., T) -> (...) [%]."""
    share: Array = 100.0 * np.mean(counts, axis=-1) / joints
    return share


def _share(rollout: Rollout, cost: str) -> Array:
    return share_of_joints(rollout.info[cost], rollout.torque.shape[-1])


register_metric(
    Metric(
        "energy",
        ("J",),
        "∫ Σ |τ_i q̇_i| dt of the applied torques",
        ("joint_velocity",),
        lambda r: mechanical_energy(r.applied_torque, r.fields["joint_velocity"], r.period),
        Presentation(EFFORT, Column("energy", ("J",)), "mechanical energy without recuperation"),
    )
)
register_metric(
    Metric(
        "excess_energy",
        ("J",),
        "∫ Σ |τ_i q̇_i| dt - |∫ Σ τ_i q̇_i dt|: work beyond the net work, which the actuators gave and took"
        " back by braking",
        ("joint_velocity",),
        lambda r: excess_energy(r.applied_torque, r.fields["joint_velocity"], r.period),
        Presentation(EFFORT),
    )
)
register_metric(
    JointMetric(
        "torque_rms",
        ("N·m", "N", "N·m"),
        "root mean square of each commanded torque",
        (),
        lambda r: root_mean_square(r.torque),
        Presentation(EFFORT, known_as="root mean square torque"),
    )
)
register_metric(
    JointMetric(
        "torque_rate",
        ("N·m/s", "N/s", "N·m/s"),
        "root mean square of each commanded torque's change per second",
        (),
        lambda r: torque_rate(r.torque, r.period),
        Presentation(EFFORT),
    )
)
register_metric(
    Metric(
        "saturation",
        ("%",),
        "share of joints and steps at or beyond the actuator limit",
        ("cost_saturation",),
        lambda r: _share(r, "cost_saturation"),
        Presentation(EFFORT, Column("satu\u00adra\u00adtion", ("%",))),
    )
)
register_metric(
    Metric(
        "joint_stop",
        ("%",),
        "share of joints and steps beyond a joint stop",
        ("cost_joint_stop",),
        lambda r: _share(r, "cost_joint_stop"),
        Presentation(EFFORT),
    )
)
