"""Contact forces that closed forms predict, beside the measured ones."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from prp_gym.baselines.admittance import AdmittanceSettings
from prp_gym.baselines.base.force_loop import ForceLoopSettings
from prp_gym.baselines.compliance import ComplianceSettings
from prp_gym.baselines.impedance import ImpedanceSettings
from prp_gym.physics.surface import Surface
from prp_gym.reproduction.contact_predictions import slowest_force_mode, spring_force
from prp_gym.robot.arrays import Array, dot
from prp_gym.viewing.plot import Line
from prp_gym.viewing.signals import Signals

_SPRINGS = (ComplianceSettings, ImpedanceSettings, AdmittanceSettings)
_WITHIN_FAST, _WITHIN_SLOW = 0.5, 0.02
"""Shares of the desired force within which the error lies where the prediction of its decay starts: with one
mode alone, and with faster ones that are over by then."""


def predicted_forces(settings: Any, signals: Signals, surface: Surface) -> Iterator[Line]:
    """The lines that theory has for the contact force of a controller.

    Args:
        settings: settings of the controller; None for a policy without settings.
        signals: signals of the last seconds.
        surface: surface of the episode, one plane.
    """
    if isinstance(settings, ForceLoopSettings) and "desired_force" in signals.fields:
        if settings.stiffness == "estimated":
            name, rate, within = "predicted: error decays as exp(-ω_c t)", settings.bandwidth, _WITHIN_FAST
        else:
            name, rate = "predicted: slowest mode", slowest_rate(settings, surface)
            within = _WITHIN_SLOW
        yield Line(name, force_decay(signals, surface, rate, within), "predicted")
    if isinstance(settings, _SPRINGS) and "desired_pose" in signals.fields:
        name = "predicted at rest: K K_P/(K + K_P) d"
        yield Line(name, force_at_rest(settings.stiffness, signals, surface), "predicted")


def pressing_force(force: Array, surface: Surface) -> Array:
    """The component (T) [N] of forces by the tip on the surface (T, 3) into the surface."""
    return -dot(force, surface.normal[0])


def slowest_rate(settings: ForceLoopSettings, surface: Surface) -> float:
    """Rate with which the force error decays in the end, with fixed gains [1/s]."""
    squares = surface.normal[0] ** 2
    inertia, derivative, proportional = (
        float(dot(squares, values[:3]))
        for values in (settings.inertia, settings.derivative_gain, settings.proportional_gain)
    )
    gains = settings.force_gain, settings.integral_gain
    return slowest_force_mode(*gains, proportional, derivative, inertia, float(surface.stiffness[0]))


def force_decay(signals: Signals, surface: Surface, rate: float, within: float) -> Array:
    """f_d + (f_0 - f_d) exp(-rate t) from where the error first lay within a share of the desired force.

    Args:
        signals: signals of the last seconds.
        surface: surface of the episode, one plane.
        rate: rate of the decay [1/s].
        within: share of the desired force [1].

    Returns:
        (T) [N]; NaN before that time, and everywhere if it is not in the window.
    """
    force = pressing_force(signals.fields["contact_force"], surface)
    desired = pressing_force(signals.fields["desired_force"], surface)
    reached = np.flatnonzero((np.abs(desired - force) <= within * desired) & (desired > 0.0))
    if len(reached) == 0 or (first := int(reached[0])) == 0:
        return np.full(len(force), np.nan)
    elapsed = signals.time - signals.time[first]
    decayed = desired + (force[first] - desired[first]) * np.exp(-rate * np.maximum(elapsed, 0.0))
    return np.where(elapsed >= 0.0, decayed, np.nan)


def force_at_rest(stiffness: Array, signals: Signals, surface: Surface) -> Array:
    """The force of two springs in series at the present depth of the desired pose.

    Args:
        stiffness: K_P of the controller (6) [N/m, ..., N m/rad, ...].
        signals: signals of the last seconds.
        surface: surface of the episode, one plane.

    Returns:
        (T) [N]; zero where the desired pose is off the surface.
    """
    along = float(dot(surface.normal[0] ** 2, stiffness[:3]))
    depth = surface.offset[0] - dot(signals.fields["desired_pose"][:, :3], surface.normal[0])
    return np.array([spring_force(along, float(surface.stiffness[0]), max(0.0, d)) for d in depth])
