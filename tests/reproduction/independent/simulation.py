"""The arm and the link, simulated in steps of 1 ms with the torque held in each."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from tests.reproduction.independent.arm import Array, ReportArm, TipMotion
from tests.reproduction.independent.free_space import PERIOD, Controller, Observed
from tests.reproduction.independent.references import Path

Signals = Mapping[str, Array]
"""Signals over time (T + 1, size) by the names that the files of the experiments use."""


WALL_MASS = 1.29e-4
"""Mass of the surface of a wall, which the simulator's soft contact needs [kg]."""


@dataclass(frozen=True, eq=False)
class Wall:
    """A plane normal·p = offset that pushes the tip towards its free side, normal·p > offset.

    Attributes:
        stiffness: K [N/m].
        normal: unit normal (3).
        offset: offset along the normal [m].
        damping: D [N s/m].
    """

    stiffness: float
    normal: Array
    offset: float
    damping: float = 0.0

    def force(self, tip: TipMotion, velocity: Array, inertia: Array, load: Array) -> Array:
        """The force of the tip on the wall (3) [N]: that of spring, damper and mass, and only a push.

        Args:
            tip: end effector.
            velocity: joint velocity (3).
            inertia: inertia matrix (3, 3).
            load: joint torques that accelerate the free arm (3).
        """
        into = -self.normal @ tip.jacobian[:3]
        depth = self.offset - float(self.normal @ tip.pose[:3])
        if depth <= 0.0:
            return np.zeros(3)
        answer = np.linalg.solve(inertia, into)
        pushed = self.stiffness * depth + self.damping * float(into @ velocity)
        pushed += WALL_MASS * float(answer @ load)
        return -max(pushed / (1.0 + WALL_MASS * float(answer @ into)), 0.0) * self.normal


def simulate_arm(
    controller: Controller,
    reference: Path,
    duration: float,
    wall: Wall | None = None,
    start: tuple[float, ...] = (0.0, 0.0, 0.0),
) -> Signals:
    """An episode of the arm from rest.

    Args:
        controller: controller.
        reference: motion that the controller is to follow, of the joints (3) or of the pose (6).
        duration: duration [s].
        wall: wall that the tip may touch.
        start: initial joint position (3) [rad, m, rad].
    """
    arm = ReportArm()
    q, v, torque = np.array(start), np.zeros(3), np.zeros(3)
    names = ("joint_position", "end_effector_pose", "contact_force", "torque", "desired")
    rows: dict[str, list[Array]] = {name: [] for name in names}
    for step in range(round(duration / PERIOD) + 1):
        tip, inertia, bias = arm.tip(q, v), arm.inertia(q), arm.bias(q, v)
        # what is measured belongs to the torque of the period before
        measured = np.zeros(3) if wall is None else wall.force(tip, v, inertia, torque - bias)
        torque = controller(Observed(step * PERIOD, q, v, measured))
        desired = reference(step * PERIOD)[0]
        for name, value in zip(names, (q, tip.pose, measured, torque, desired), strict=True):
            rows[name].append(value)
        load = torque - bias
        if wall is not None:
            load = load - tip.jacobian[:3].T @ wall.force(tip, v, inertia, load)
        v = v + PERIOD * np.linalg.solve(inertia, load)
        q = q + PERIOD * v
    signals = {name: np.array(values) for name, values in rows.items()}
    path = signals.pop("desired")
    if path.shape[1] == len(start):
        return {**signals, "joint_error": path - signals["joint_position"]}
    return {**signals, "pose_error": path - signals["end_effector_pose"]}


@dataclass(frozen=True)
class Adaptation:
    """Numbers of adaptive control of the link.

    Attributes:
        slope: Λ [1/s].
        damping: K_D [N m s/rad].
        rates: adaptation gains of inertia, friction and gravity moment (3).
        estimate: initial estimates (3).
    """

    slope: float
    damping: float
    rates: tuple[float, ...]
    estimate: tuple[float, ...]


def simulate_link(numbers: Adaptation, plant: tuple[float, ...], reference: Path, duration: float) -> Signals:
    """An episode of the link (I, F, G) under adaptive control; viscous friction is integrated implicitly."""
    inertia, friction, weight = plant
    estimate, q, v = np.array(numbers.estimate), 0.0, 0.0
    rows: dict[str, list[list[float]]] = {"joint_position": [], "joint_error": [], "torque": []}
    estimates = [[math.nan] * 3]
    for step in range(round(duration / PERIOD) + 1):
        desired, rate, acceleration = (float(part[0]) for part in reference(step * PERIOD))
        reference_rate = rate + numbers.slope * (desired - q)
        columns = np.array([acceleration + numbers.slope * (rate - v), reference_rate, math.sin(q)])
        sliding = reference_rate - v
        torque = float(columns @ estimate) + numbers.damping * sliding
        estimate = estimate + PERIOD * np.array(numbers.rates) * columns * sliding
        for name, value in (("joint_position", q), ("joint_error", desired - q), ("torque", torque)):
            rows[name].append([value])
        estimates.append(estimate.tolist())
        load = torque - friction * v - weight * math.sin(q)
        v += PERIOD * load / (inertia + PERIOD * friction)
        q += PERIOD * v
    return {**{n: np.array(r) for n, r in rows.items()}, "parameter_estimate": np.array(estimates[:-1])}
