"""A controller in closed loop with the closed-form model of the arm: torques are held, steps are of 1 ms."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from prp_gym.baselines import Baseline
from prp_gym.robot import NOMINAL, PRPArm, RobotParameters
from tests.support import contact_plant
from tests.support.arm_motion import STEP, Arms, advance

Array = NDArray[np.float64]
Motion = tuple[Array, Array, Array]
Reference = Callable[[float], Motion]


@dataclass(frozen=True)
class Wall:
    """An ideal one-sided spring at y = `offset` [m], pressed from below; a stiffness [N/m] per row."""

    stiffness: Array | float
    offset: float = -0.44

    def force(self, pose: Array) -> Array:
        """The force by the tip on the wall (..., 3) [N]."""
        force = np.zeros((*pose.shape[:-1], 3))
        force[..., 1] = self.stiffness * np.maximum(pose[..., 1] - self.offset, 0.0)
        return force

    def plane(self, rows: int) -> contact_plant.Wall:
        """The wall of each row, as a plane with its normal towards the free side."""
        stiffness = np.broadcast_to(self.stiffness, (rows,))
        normal = np.tile([0.0, -1.0, 0.0], (rows, 1))
        return contact_plant.Wall(stiffness, normal, np.full(rows, -self.offset), np.zeros(rows))


NO_WALL = Wall(0.0)


@dataclass(frozen=True)
class Run:
    """The recording of a simulation, at the start of each control period; all (T, N, size)."""

    joint_position: Array
    pose: Array
    desired_position: Array
    desired_pose: Array
    torque: Array
    force: Array

    @property
    def joint_error(self) -> Array:
        """The joint error q̃."""
        error: Array = self.desired_position - self.joint_position
        return error

    @property
    def pose_error(self) -> Array:
        """The pose error x̃."""
        error: Array = self.desired_pose - self.pose
        return error


def hold(position: Any) -> Reference:
    """A constant reference (N, 3)."""
    goal = np.atleast_2d(np.asarray(position, dtype=np.float64))
    return lambda time: (goal, np.zeros_like(goal), np.zeros_like(goal))


def quintic(start: Any, goal: Any, duration: float) -> Reference:
    """From rest to rest, then held."""
    begin, path = np.atleast_2d(start).astype(float), np.atleast_2d(np.subtract(goal, start)).astype(float)

    def at(time: float) -> Motion:
        s = min(time / duration, 1.0)
        rate = 30 * s**2 - 60 * s**3 + 30 * s**4
        curve = 60 * s - 180 * s**2 + 120 * s**3
        progress = 10 * s**3 - 15 * s**4 + 6 * s**5
        return begin + progress * path, rate / duration * path, curve / duration**2 * path

    return at


def simulate(
    controller: Baseline[Any],
    start: Any,
    reference: Reference,
    duration: float,
    plants: Sequence[RobotParameters] = (NOMINAL,),
    wall: Wall = NO_WALL,
) -> Run:
    """From rest at `start` (N, 3), without joint stops, of one plant for all rows or one for each."""
    arm, arms = PRPArm(), Arms.of(plants)
    q = np.atleast_2d(np.asarray(start, dtype=np.float64))
    velocity, state, records = np.zeros_like(q), None, []
    names = controller.interface.layout.names
    poses = "end_effector_pose" in controller.measured_fields or "desired_pose" in names
    plane = None if wall is NO_WALL else wall.plane(len(q))
    for step in range(round(duration / controller.interface.period)):
        desired = reference(step * controller.interface.period)
        fields = _joint_fields(q, velocity, desired)
        if poses:
            fields |= _pose_fields(arm, q, velocity, desired, wall)
        sized = [_sized(fields, name, len(q)) for name in names]
        action, state = controller.predict(np.concatenate(sized, axis=-1), state)
        torque = action.astype(np.float64) * controller.interface.torque_limit
        records.append((q, np.broadcast_to(desired[0], q.shape), torque))
        q, velocity = advance(arms, q, velocity, torque, plane, round(controller.interface.period / STEP))
    positions, wanted, torques = (np.array(column) for column in zip(*records, strict=True))
    pose = arm.forward_kinematics(positions)
    return Run(
        joint_position=positions,
        pose=pose,
        desired_position=wanted,
        desired_pose=arm.forward_kinematics(wanted),
        torque=torques,
        force=wall.force(pose),
    )


def _sized(fields: dict[str, Array], name: str, rows: int) -> Array:
    """(rows, size) of a field; those of an arm whose pose nobody reads are zero."""
    if name not in fields:
        return np.zeros((rows, 3 if name == "contact_force" else 6))
    return np.broadcast_to(fields[name], (rows, fields[name].shape[-1]))


def _joint_fields(q: Array, velocity: Array, desired: Motion) -> dict[str, Array]:
    return {
        "joint_position": q,
        "joint_velocity": velocity,
        "desired_joint_position": desired[0],
        "desired_joint_velocity": desired[1],
        "desired_joint_acceleration": desired[2],
    }


def _pose_fields(arm: PRPArm, q: Array, velocity: Array, desired: Motion, wall: Wall) -> dict[str, Array]:
    pose, rate, _ = arm.pose_motion(q, velocity, np.zeros_like(q))
    motion = arm.pose_motion(*desired)
    return {
        "end_effector_pose": pose,
        "end_effector_velocity": rate,
        "contact_force": wall.force(pose),
        "desired_pose": motion[0],
        "desired_velocity": motion[1],
        "desired_acceleration": motion[2],
    }
