"""References of the arm: motions of its joints or of its pose, and desired forces."""

from collections.abc import Callable, Mapping
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from prp_gym.drawing.overlay import Ball, OverlayItem, Path
from prp_gym.palette import REFERENCE, rgba
from prp_gym.robot.arm import PRPArm
from prp_gym.robot.arrays import Array, zeros
from prp_gym.tasks.fields import DESIRED_FORCE, JOINT_REFERENCE_FIELDS, POSE_REFERENCE_FIELDS, Field
from prp_gym.tasks.parts import Reference
from prp_gym.tasks.trajectory import Trajectory

_PATH_POINTS = 301
_GOAL_SIZE = 0.012  # m
_GOAL_COLOR, _PATH_COLOR = rgba(REFERENCE), rgba(REFERENCE, 0.8)


def path_overlay(
    trajectory: Trajectory, tip_path: Callable[[Trajectory, Array], Array], duration: float
) -> list[OverlayItem]:
    """The overlay of a whole reference: the path of the tip, or a ball at the goal where it does not move.

    Args:
        trajectory: Reference of one environment, one row.
        tip_path: Function that gives the tip positions (..., 1, 3) [m] at times (..., 1) [s].
        duration: Duration of the path [s].
    """
    if trajectory.is_constant:
        return [Ball(tip_path(trajectory, np.zeros(1))[0], _GOAL_SIZE, _GOAL_COLOR)]
    time = np.linspace(0.0, duration, _PATH_POINTS)[:, None]
    return [Path(tip_path(trajectory, time)[:, 0], 2.0, _PATH_COLOR)]


def sample_pose(arm: PRPArm, trajectory: Trajectory, time: Array) -> Array:
    """Sample a reference as a motion of the pose.

    Args:
        arm: Arm whose kinematics turn motions of the joints into motions of the pose.
        trajectory: Motion of the joints or of the pose, N rows.
        time: Times (..., N) [s].

    Returns:
        Pose and its first and second time derivatives (..., N, 18).
    """
    samples = trajectory.sample(time)
    if samples.shape[-1] == 18:
        return samples
    return np.concatenate(arm.pose_motion(samples[..., :3], samples[..., 3:6], samples[..., 6:]), axis=-1)


class JointSpaceReference(Reference):
    """Motions of the joints, observed as motions of the joints.

    Args:
        arm: Nominal arm.
    """

    fields: ClassVar[tuple[Field, ...]] = JOINT_REFERENCE_FIELDS

    def __init__(self, arm: PRPArm) -> None:
        super().__init__()
        self._arm = arm

    def sample(self, time: Array, ids: NDArray[np.intp] | None = None) -> Array:
        """See `Reference.sample`."""
        return self.rows(ids).sample(time)

    def overlay(self, index: int, duration: float) -> list[OverlayItem]:
        """See `Reference.overlay`."""
        trajectory = self.trajectory.rows(np.array([index]))
        return path_overlay(trajectory, self._tip_path, duration)

    def _tip_path(self, trajectory: Trajectory, time: Array) -> Array:
        return self._arm.forward_kinematics(trajectory.sample(time)[..., :3])[..., :3]


class PoseSpaceReference(Reference):
    """Motions of the joints or of the pose, observed as motions of the pose.

    Args:
        arm: Nominal arm.
    """

    fields: ClassVar[tuple[Field, ...]] = POSE_REFERENCE_FIELDS

    def __init__(self, arm: PRPArm) -> None:
        super().__init__()
        self._arm = arm

    def sample(self, time: Array, ids: NDArray[np.intp] | None = None) -> Array:
        """See `Reference.sample`."""
        return sample_pose(self._arm, self.rows(ids), time)

    def overlay(self, index: int, duration: float) -> list[OverlayItem]:
        """See `Reference.overlay`."""
        trajectory = self.trajectory.rows(np.array([index]))
        return path_overlay(trajectory, self._tip_path, duration)

    def _tip_path(self, trajectory: Trajectory, time: Array) -> Array:
        return sample_pose(self._arm, trajectory, time)[..., :3]


class ForceAndPoseReference(PoseSpaceReference):
    """Motions of the pose, each with a constant desired force by the tip on the surface."""

    fields = (*POSE_REFERENCE_FIELDS, DESIRED_FORCE)
    state_arrays: ClassVar[Mapping[str, int]] = {"_forces": 0}

    def __init__(self, arm: PRPArm) -> None:
        super().__init__(arm)
        self._forces = np.zeros((0, 3))

    def begin(self, ids: NDArray[np.intp], start: Any) -> None:
        """See `Reference.begin`."""
        super().begin(ids, start)
        if len(self._forces) == 0:
            self._forces = np.zeros((len(ids), 3))
        self._forces[ids] = start.desired_force

    def sample(self, time: Array, ids: NDArray[np.intp] | None = None) -> Array:
        """See `Reference.sample`."""
        pose = super().sample(time, ids)
        sample = zeros((*pose.shape[:-1], pose.shape[-1] + 3), pose)
        sample[..., :-3] = pose
        sample[..., -3:] = self._forces if ids is None else self._forces[ids]
        return sample
