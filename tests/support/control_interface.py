"""Interfaces and observations with which controllers are tested without an environment."""

import numpy as np
from numpy.typing import NDArray

from prp_gym.baselines import ControlInterface
from prp_gym.robot import Link, PRPArm
from prp_gym.tasks.fields import (
    CONTACT_FORCE,
    JOINT_REFERENCE_FIELDS,
    LINK_FIELDS,
    LINK_REFERENCE_FIELDS,
    MEASURED_FIELDS,
    POSE_REFERENCE_FIELDS,
    ObservationLayout,
)
from tests.support.pinocchio_model import PinocchioArm, random_states

Array = NDArray[np.float64]
Observed = dict[str, Array]

LIMIT = np.array([50.0, 100.0, 10.0])
PERIOD = 0.002
JOINT_LAYOUT = ObservationLayout((*MEASURED_FIELDS, *JOINT_REFERENCE_FIELDS))
POSE_LAYOUT = ObservationLayout((*MEASURED_FIELDS, CONTACT_FORCE, *POSE_REFERENCE_FIELDS))
LINK_LAYOUT = ObservationLayout((*LINK_FIELDS, *LINK_REFERENCE_FIELDS))

INTERFACE = ControlInterface("PRP-JointTracking-v0", JOINT_LAYOUT, LIMIT, PERIOD, PRPArm())
POSE_INTERFACE = ControlInterface("PRP-Impedance-v0", POSE_LAYOUT, LIMIT, PERIOD, PRPArm())
LINK_INTERFACE = ControlInterface("PRP-Adaptive-v0", LINK_LAYOUT, np.array([30.0]), PERIOD, Link())


def oracle_jacobian(arm: PinocchioArm, q: Array) -> Array:
    """J_A (6, 3) from Pinocchio's linear rows, and from α = q_1, β = π/2 - q_3, γ = π/2."""
    return np.vstack([arm.tip_jacobian(q)[:3], [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 0.0, 0.0]]])


def oracle_drift(arm: PinocchioArm, q: Array, velocity: Array) -> Array:
    """J̇_A q̇ (6) by central differences; off by 1e-9 at speeds up to 3."""
    h = 1e-5
    change = oracle_jacobian(arm, q + h * velocity) - oracle_jacobian(arm, q - h * velocity)
    return np.asarray(change @ velocity / (2 * h))


def oracle_pose(arm: PinocchioArm, q: Array) -> Array:
    """x (6)."""
    return np.concatenate([arm.tip_transform(q)[:3, 3], [q[0], np.pi / 2 - q[2], np.pi / 2]])


def random_pose_observation(arm: PinocchioArm, seed: int, count: int) -> Observed:
    """Random measurements of the arm, and attainable references, each (count, size)."""
    q, velocity, _, force = random_states(seed, count)
    goal, goal_velocity, goal_acceleration, _ = random_states(seed + 1, count)
    return {
        "joint_position": q,
        "joint_velocity": velocity,
        "end_effector_pose": np.array([oracle_pose(arm, row) for row in q]),
        "end_effector_velocity": _rates(arm, q, velocity),
        "contact_force": force,
        "desired_pose": np.array([oracle_pose(arm, row) for row in goal]),
        "desired_velocity": _rates(arm, goal, goal_velocity),
        "desired_acceleration": _rates(arm, goal, goal_acceleration)
        + np.array([oracle_drift(arm, *row) for row in zip(goal, goal_velocity, strict=True)]),
    }


def column_space_of(arm: PinocchioArm, observed: Observed, vectors: Array) -> Array:
    """J_Aᵀ times pose vectors (count, 6): what of them the joints can feel or do, (count, 3)."""
    rows = zip(observed["joint_position"], vectors, strict=True)
    return np.array([oracle_jacobian(arm, q).T @ vector for q, vector in rows])


def pose_acceleration(arm: PinocchioArm, observed: Observed, torque: Array, force: Array) -> Array:
    """ẍ (count, 6) that torques and forces by the tip on a surface cause, by Pinocchio."""
    rows = zip(observed["joint_position"], observed["joint_velocity"], torque, force, strict=True)
    return np.array(
        [
            oracle_jacobian(arm, q) @ arm.forward_dynamics(q, velocity, tau, h)
            + oracle_drift(arm, q, velocity)
            for q, velocity, tau, h in rows
        ]
    )


def rows_of(observed: Observed) -> list[Observed]:
    """The observations of a batch one by one."""
    count = len(next(iter(observed.values())))
    return [{name: values[index] for name, values in observed.items()} for index in range(count)]


def _rates(arm: PinocchioArm, q: Array, velocity: Array) -> Array:
    return np.array([oracle_jacobian(arm, a) @ b for a, b in zip(q, velocity, strict=True)])
