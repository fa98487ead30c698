"""Errors of the motion that closed forms predict, beside the measured ones."""

from typing import Any

import numpy as np

from prp_gym.baselines.compliance import ComplianceSettings
from prp_gym.baselines.joint_inverse_dynamics import JointInverseDynamicsSettings
from prp_gym.baselines.joint_pd import JointPDSettings
from prp_gym.baselines.operational_pd import OperationalPDSettings
from prp_gym.reproduction.predictions import error_decay
from prp_gym.robot.arm import PRPArm
from prp_gym.robot.arrays import Array, apply_transposed, norm
from prp_gym.viewing.signals import Signals

_ACROSS = 0.02  # share of a disturbance that may act across the slide, which turns while the arm yields


def predicted_joint_errors(settings: Any, signals: Signals, from_rest: bool) -> tuple[str, Array] | None:
    """Name and values (T, joints) of the joint errors that theory has for a controller, in joint units.

    Args:
        settings: settings of the controller; None for a policy without settings.
        signals: signals of the last seconds.
        from_rest: whether the window begins with the start of an episode at rest, the reference is constant,
            and nothing was changed since.

    Returns:
        None where theory has no closed form.
    """
    if isinstance(settings, JointPDSettings) and signals.disturbance.any() and _full_gravity(settings):
        error = -signals.disturbance / settings.proportional_gain
        return "predicted at rest: disturbance/K_P", np.where(signals.disturbance != 0.0, error, np.nan)
    if not isinstance(settings, JointInverseDynamicsSettings) or not from_rest:
        return None
    if np.any(settings.integral_gain) or settings.model is not None:
        return None
    start = signals.fields["desired_joint_position"][0] - signals.fields["joint_position"][0]
    gains = zip(start, settings.proportional_gain, settings.derivative_gain, strict=True)
    errors = [first * error_decay(signals.time, float(k_p), float(k_d)) for first, k_p, k_d in gains]
    return "predicted: second-order response", np.stack(errors, axis=-1)


def predicted_tip_error(settings: Any, signals: Signals, arm: PRPArm) -> tuple[str, Array] | None:
    """Name and values (T, 3) [m] of the tip's deflection at rest under a force along the slide: F/K_P.

    Across the slide the arm cannot yield without rotating, so that the springs of the angles act too.

    Args:
        settings: settings of the controller; None for a policy without settings.
        signals: signals of the last seconds.
        arm: nominal arm.

    Returns:
        None for another controller, and without a disturbance.
    """
    if isinstance(settings, ComplianceSettings):
        stiffness = settings.stiffness[:3]
    elif isinstance(settings, OperationalPDSettings):
        stiffness = settings.proportional_gain[:2]  # of the plane in which the slide lies
    else:
        return None
    if np.ptp(stiffness) > 0.0 or not signals.disturbance.any():
        return None
    q, along = signals.fields["joint_position"], signals.disturbance[:, 1]
    force = along[:, None] * slide_direction(q)
    across = signals.disturbance - apply_transposed(arm.analytical_jacobian(q)[:, :3], force)
    pushed = (along != 0.0) & (norm(across) <= _ACROSS * norm(signals.disturbance))
    deflection = np.where(pushed[:, None], -force / stiffness[0], np.nan)
    return "predicted at rest: F/K_P", deflection


def slide_direction(joint_position: Array) -> Array:
    """Unit vectors (..., 3) in the world frame along which an extending slide moves the tip.

    Args:
        joint_position: q (..., 3) [rad, m, rad].
    """
    angle = joint_position[..., 0]
    return np.stack([np.sin(angle), -np.cos(angle), np.zeros_like(angle)], axis=-1)


def _full_gravity(settings: JointPDSettings) -> bool:
    """Whether the controller compensates the gravity at the measured position."""
    return settings.gravity == "current"
