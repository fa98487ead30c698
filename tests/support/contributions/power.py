"""Metrics of the mechanical power."""

import numpy as np

from prp_gym.evaluation.column import Column
from prp_gym.evaluation.metric import Metric, MetricGroup, Presentation
from prp_gym.evaluation.metrics import register_metric
from prp_gym.robot.arrays import Array

POWER = MetricGroup("Power")


def peak_power(torque: Array, velocity: Array) -> Array:
    """Largest sum over the joints of |τ_i q̇_i|, with the velocities at the start of each control period.

    Args:
        torque: (..., T, joints) [N m, N, N m].
        velocity: (..., T + 1, joints) joint velocities [rad/s, m/s, rad/s].

    Returns:
        (...) [W].
    """
    power: Array = np.abs(torque * velocity[..., :-1, :]).sum(axis=-1).max(axis=-1)
    return power


register_metric(
    Metric(
        "peak_power",
        ("W",),
        "largest sum over the joints of |τ_i q̇_i| of the applied torques",
        ("joint_velocity",),
        lambda rollout: peak_power(rollout.applied_torque, rollout.fields["joint_velocity"]),
        Presentation(POWER, Column("peak power", ("W",))),
    )
)
