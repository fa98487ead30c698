"""A plant for tests of controllers in contact, independent of MuJoCo: closed forms and one-sided springs."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from prp_gym.baselines import Baseline, ControlInterface
from prp_gym.robot import NOMINAL, PRPArm, RobotParameters
from prp_gym.tasks.fields import (
    CONTACT_FORCE,
    DESIRED_FORCE,
    MEASURED_FIELDS,
    POSE_REFERENCE_FIELDS,
    ObservationLayout,
)
from tests.support.arm_motion import STEP, Arms, advance

Array = NDArray[np.float64]
Reference = Callable[[float], tuple[Array, Array, Array]]

LIMIT = np.array([50.0, 100.0, 10.0])  # [N m, N, N m]
LAYOUT = ObservationLayout((*MEASURED_FIELDS, CONTACT_FORCE, *POSE_REFERENCE_FIELDS, DESIRED_FORCE))
WITHOUT_DESIRED_FORCE = ObservationLayout((*MEASURED_FIELDS, CONTACT_FORCE, *POSE_REFERENCE_FIELDS))


def interface(
    period: float = 0.002, limit: Array = LIMIT, layout: ObservationLayout = LAYOUT
) -> ControlInterface:
    return ControlInterface("PRP-Force-v0", layout, limit, period, PRPArm())


def held(pose: Array) -> Reference:
    """A constant reference."""
    return lambda _: (pose, np.zeros(pose.shape), np.zeros(pose.shape))


@dataclass(frozen=True, eq=False)
class Wall:
    """Elastic planes, one per simulation: the points with normal·p = offset, free where it is more.

    Attributes:
        stiffness: Stiffness (n) [N/m].
        normal: Unit normals towards the free side (n, 3).
        offset: Offsets along the normals (n) [m].
        damping: Damping (n) [N s/m].
    """

    stiffness: Array
    normal: Array
    offset: Array
    damping: Array

    @classmethod
    def ahead(cls, tip: Array, into: Array, gap: Array, stiffness: Array, damping: float = 0.0) -> "Wall":
        """Walls at a distance `gap` (n) from the tips (n, 3), in the directions `into` (n, 3)."""
        offset = -np.sum(into * tip, axis=-1) - gap
        return cls(stiffness, -into, offset, np.full(stiffness.shape, damping))

    def force(self, tip: Array, velocity: Array) -> Array:
        """The force by the tip on the wall (n, 3) [N]."""
        depth = self.offset - np.sum(self.normal * tip, axis=-1)
        rate = -np.sum(self.normal * velocity, axis=-1)
        pressing = np.maximum(0.0, self.stiffness * depth + self.damping * rate) * (depth > 0.0)
        force: Array = -self.normal * pressing[:, None]
        return force


@dataclass(frozen=True, eq=False)
class Imperfection:
    """Deviations of the plant from the nominal arm with an ideal force sensor.

    Attributes:
        parameters: Parameters of the arm: those of all simulations, or of each.
        noise: Standard deviation of every component of the measured force, (1) or (n) [N].
        bias: Bias of the measured force (n, 3) [N].
        delay: Actuation delay in control periods.
    """

    parameters: tuple[RobotParameters, ...] = (NOMINAL,)
    noise: Array = field(default_factory=lambda: np.zeros(1))
    bias: Array = field(default_factory=lambda: np.zeros(3))
    delay: int = 0


@dataclass(frozen=True, eq=False)
class Recording:
    """The recording of a simulation, with one sample for each control period.

    Attributes:
        time: Time of each sample (t) [s].
        force: True force by the tip on the wall (t, n, 3) [N].
        pose: Pose of the tip (t, n, 6).
        joint_position: Joint position (t, n, 3).
        action: Action of the controller (t, n, 3).
    """

    time: Array
    force: Array
    pose: Array
    joint_position: Array
    action: Array
    state: tuple[Array, ...]


def simulate(
    controller: Baseline[Any],
    joint_position: Array,
    wall: Wall,
    desired_force: Array,
    duration: float,
    reference: Reference | None = None,
    imperfection: Imperfection | None = None,
) -> Recording:
    """Simulate a controller on n arms at once, from rest at `joint_position` (n, 3)."""
    world = imperfection or Imperfection()
    arms, arm, generator = Arms.of(world.parameters), PRPArm(), np.random.default_rng(5)
    q, v = joint_position.copy(), np.zeros(joint_position.shape)
    reference = reference or held(arm.forward_kinematics(q))
    period, limit = controller.interface.period, controller.interface.torque_limit
    state, records, queue = None, [], [_holding(world.parameters, q) / limit] * world.delay
    for index in range(round(duration / period)):
        pose, jacobian = arm.forward_kinematics(q), arm.analytical_jacobian(q)
        rate = np.einsum("nij,nj->ni", jacobian, v)
        force = wall.force(pose[:, :3], rate[:, :3])
        sensed = force + world.bias + world.noise[:, None] * generator.standard_normal(force.shape)
        wanted = [np.broadcast_to(part, pose.shape) for part in reference(index * period)]
        parts = [q, v, pose, rate, sensed, *wanted, desired_force]
        observation = np.concatenate(parts[: len(controller.interface.layout.names)], axis=-1)
        action, state = controller.predict(observation, state)
        records.append((index * period, force, pose, q, action))
        queue.append(action.astype(np.float64))
        q, v = advance(arms, q, v, queue.pop(0) * limit, wall, round(period / STEP))
    time, forces, poses, joints, actions = (np.array(column) for column in zip(*records, strict=True))
    return Recording(time, forces, poses, joints, actions, state or ())


def _holding(parameters: tuple[RobotParameters, ...], q: Array) -> Array:
    """Torques that hold the arms (n, 3)."""
    each = parameters if len(parameters) == len(q) else parameters * len(q)
    return np.array([PRPArm(own).gravity_vector(row) for own, row in zip(each, q, strict=True)])
