"""The controllers of free space, each a function of what is observed at the start of a period."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from tests.reproduction.independent.arm import Array, ReportArm, TipMotion
from tests.reproduction.independent.references import Path

PERIOD = 1e-3  # s


class Observed(NamedTuple):
    """What a controller observes.

    Attributes:
        time: time since the start [s].
        q: joint position (3).
        v: joint velocity (3).
        force: force of the tip on the surface (3) [N].
    """

    time: float
    q: Array
    v: Array
    force: Array


Controller = Callable[[Observed], Array]


def joint_pd(reference: Path, arm: ReportArm, K_P: Array, K_D: Array, gravity: str = "current") -> Controller:
    """PD control; gravity compensation at the current or the desired position, or none."""

    def torque(now: Observed) -> Array:
        desired, rate, _ = reference(now.time)
        load = {"current": arm.gravity(now.q), "desired": arm.gravity(desired), "none": np.zeros(3)}
        return load[gravity] + K_P * (desired - now.q) + K_D * (rate - now.v)

    return torque


def joint_inverse_dynamics(reference: Path, model: ReportArm, K_P: float, K_D: float) -> Controller:
    """Computed torque."""

    def torque(now: Observed) -> Array:
        desired, rate, acceleration = reference(now.time)
        y = acceleration + K_D * (rate - now.v) + K_P * (desired - now.q)
        return model.inertia(now.q) @ y + model.bias(now.q, now.v)

    return torque


def operational_pd(reference: Path, arm: ReportArm, K_P: float, K_D: float) -> Controller:
    """PD control of the pose with gravity compensation."""

    def torque(now: Observed) -> Array:
        desired, rate, _ = reference(now.time)
        tip = arm.tip(now.q, now.v)
        pull = K_P * (desired - tip.pose) + K_D * (rate - tip.jacobian @ now.v)
        return arm.gravity(now.q) + tip.jacobian.T @ pull

    return torque


def resolved(arm: ReportArm, now: Observed, tip: TipMotion, acceleration: Array) -> Array:
    """The torque that gives the end effector an acceleration as nearly as three joints can."""
    y = np.linalg.lstsq(tip.jacobian, acceleration - tip.drift, rcond=None)[0]
    return arm.inertia(now.q) @ y + arm.bias(now.q, now.v)


def operational_inverse_dynamics(reference: Path, arm: ReportArm, K_P: float, K_D: float) -> Controller:
    """Computed torque for the pose."""

    def torque(now: Observed) -> Array:
        desired, rate, acceleration = reference(now.time)
        tip = arm.tip(now.q, now.v)
        wanted = acceleration + K_D * (rate - tip.jacobian @ now.v) + K_P * (desired - tip.pose)
        return resolved(arm, now, tip, wanted)

    return torque
