"""Inverse kinematics of the tip position: all four branches, and the one closest to a seed."""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from prp_gym.errors import UnreachableError
from prp_gym.robot.arrays import Array, as_vectors, broadcast, elementwise, norm, total, zeros
from prp_gym.robot.kinematics import Kinematics
from prp_gym.robot.parameters import JOINT_UNITS

_TOLERANCE = 1e-8  # [rad] or [m]: rounding of a point on a limit, √ε a_3 where two branches meet
_COS_3_SIGNS = np.array([1.0, 1.0, -1.0, -1.0])
_REACH_SIGNS = np.array([1.0, -1.0, 1.0, -1.0])


def branches(kinematics: Kinematics, tip_position: Array) -> Array:
    """The four solutions of the position equations, without regard to the joint limits.

    Where a square root has no real value, its argument is clipped to zero, and the solution does not
    attain the point; compare its forward kinematics with the point to detect this.

    Args:
        kinematics: Kinematics of the arm.
        tip_position: (..., 3) in the world frame [m].

    Returns:
        (..., 4, 3) [rad, m, rad]; the branches are (sign C_3, sign L) = ++, +-, -+, --.

    Source: [R] 1.3, with its misprints corrected.
    """
    geometry = kinematics.parameters.geometry
    a_1, a_3 = geometry.first_link_offset, geometry.third_link_length
    x, y, z = (tip_position[..., None, axis] for axis in range(3))
    sin_3 = np.clip((z - geometry.base_height) / a_3, -1.0, 1.0)
    cos_3 = _COS_3_SIGNS * np.sqrt(1.0 - sin_3**2)
    reach = _REACH_SIGNS * np.sqrt(np.maximum(x**2 + y**2 - a_1**2, 0.0))
    joints = zeros((*tip_position.shape[:-1], 4, 3), tip_position)
    joints[..., 0] = elementwise(math.atan2, reach * x + a_1 * y, a_1 * x - reach * y)
    joints[..., 1] = reach - geometry.slide_offset - a_3 * cos_3
    joints[..., 2] = elementwise(math.atan2, np.broadcast_to(sin_3, cos_3.shape), cos_3)
    return joints


class InverseKinematics(Kinematics):
    """Joint positions that put the tip at a point."""

    def inverse_kinematics_branches(self, tip_position: ArrayLike) -> tuple[Array, NDArray[np.bool_]]:
        """All joint positions that attain a point, and whether they are within the joint limits.

        Args:
            tip_position: (..., 3) in the world frame [m].

        Returns:
            joint positions (..., 4, 3) [rad, m, rad], and whether each one attains the point within the
            limits (..., 4). Branches: (sign C_3, sign L) = ++, +-, -+, --.

        Raises:
            ShapeError: an argument does not have three components.
            NonFiniteError: NaN or infinity in the point.
        """
        point = as_vectors(tip_position, "tip_position")
        low, high = self.joint_limits
        joints = self._turned_into_range(branches(self, point))
        inside = (joints >= low - _TOLERANCE) & (joints <= high + _TOLERANCE)
        within = np.logical_and.reduce(inside, axis=-1)
        missed = np.abs(self.forward_kinematics(joints)[..., :3] - point[..., None, :]).max(axis=-1)
        joints = np.where(within[..., None], np.clip(joints, low, high), joints)
        return joints, within & (missed < _TOLERANCE)

    def inverse_kinematics(self, tip_position: ArrayLike, seed: ArrayLike) -> Array:
        """The joint position that attains a point and is closest to a seed.

        Args:
            tip_position: (..., 3) in the world frame [m].
            seed: (..., 3) [rad, m, rad]; distance is measured in fractions of the joint ranges.

        Returns:
            (..., 3) [rad, m, rad], within the joint limits.

        Raises:
            ShapeError: an argument does not have three components.
            NonFiniteError: NaN or infinity in the point or the seed.
            UnreachableError: no branch attains the point within the limits; the error holds the distance
                [m] of the closest branch, clipped to the limits, and the limits that it exceeds.
        """
        point = as_vectors(tip_position, "tip_position")
        start = as_vectors(seed, "seed")
        point, start = broadcast(point, start)
        joints, valid = self.inverse_kinematics_branches(point)
        joints = self._turned_towards(joints, start)
        reachable = valid.any(axis=-1)
        if not reachable.all():
            raise self._unreachable(point[~reachable][0])
        low, high = self.joint_limits
        span = high - low
        distance = total(np.square((joints - start[..., None, :]) / span))
        best = np.where(valid, distance, np.inf).argmin(axis=-1)
        chosen: Array = np.take_along_axis(joints, best[..., None, None], axis=-2)[..., 0, :]
        return chosen

    def _turned_into_range(self, joints: Array) -> Array:
        """Angles of joints 1 and 3 (..., 3), moved into the limits by full turns where possible."""
        for joint in (0, 2):
            low, high = self.parameters.joint_lower[joint], self.parameters.joint_upper[joint]
            angle = joints[..., joint]
            turned = low + np.mod(angle - low, 2 * np.pi)
            outside = (angle < low - _TOLERANCE) | (angle > high + _TOLERANCE)
            joints[..., joint] = np.where(outside & (turned <= high + _TOLERANCE), turned, angle)
        return joints

    def _turned_towards(self, joints: Array, seed: Array) -> Array:
        """Angles of joints 1 and 3, moved by full turns towards a seed where the limits permit it."""
        for joint in (0, 2):
            low, high = self.parameters.joint_lower[joint], self.parameters.joint_upper[joint]
            angle = joints[..., joint]
            turned = angle + 2 * np.pi * np.round((seed[..., None, joint] - angle) / (2 * np.pi))
            joints[..., joint] = np.where((turned >= low) & (turned <= high), turned, angle)
        return joints

    def _unreachable(self, point: Array) -> UnreachableError:
        low, high = self.joint_limits
        joints = self._turned_into_range(branches(self, point))
        clipped = np.clip(joints, low, high)
        misses = norm(self.forward_kinematics(clipped)[..., :3] - point)
        best = int(misses.argmin())
        return UnreachableError(
            point.tolist(), float(misses[best]), self._broken_limits(point, joints[best], low, high)
        )

    def _broken_limits(self, point: Array, joint: Array, low: Array, high: Array) -> list[str]:
        geometry = self.parameters.geometry
        broken = []
        height = point[2] - geometry.base_height
        if abs(height) > geometry.third_link_length:
            broken.append(
                f"height {point[2]:.6g} m is not within {geometry.third_link_length:g} m"
                f" of {geometry.base_height:g} m"
            )
        radius = float(np.hypot(point[0], point[1]))
        if radius < geometry.first_link_offset:
            broken.append(
                f"distance {radius:.6g} m from joint 1's axis is below {geometry.first_link_offset:g} m"
            )
        for index, unit in enumerate(JOINT_UNITS):
            if not low[index] - _TOLERANCE <= joint[index] <= high[index] + _TOLERANCE:
                broken.append(
                    f"joint {index + 1} would be {joint[index]:.6g} {unit}, allowed {low[index]:.6g} to"
                    f" {high[index]:.6g} {unit}"
                )
        return broken
