"""`Viewpoint`: where a camera stands that frames what matters."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import mujoco
import numpy as np

from prp_gym.drawing.overlay import OverlayItem, Path
from prp_gym.drawing.surface_patch import HALF_SIZE, SurfacePatch
from prp_gym.robot.arrays import Array

FIELD_OF_VIEW = 35.0
"""Vertical angle that the free cameras see [deg]."""

_FILLED = 0.88  # of the frame
_POST = np.array([[0.0, 0.0, -0.15], [0.0, 0.0, 0.2]])  # that carries the robot [m]
_CORNERS = np.array([[a, b, c] for a in (-1.0, 1.0) for b in (-1.0, 1.0) for c in (-1.0, 1.0)])
_ROUND = np.linspace(0.0, 2.0 * np.pi, 24)
_WORKSPACE = np.stack(
    [0.56 * np.cos(_ROUND), 0.56 * np.sin(_ROUND), np.full_like(_ROUND, 0.15)], axis=-1
)  # [m]
_NEAR_TIP = 0.12  # [m]
_SLIDE_RADIUS, _SLIDE_HEIGHT = 0.46, 0.15  # of the rear end of the slide, from the base [m]
_ASIDE, _BESIDE = (
    40.0,
    32.0,
)  # of the camera from the middle of the motion, and from the surface's plane [deg]
_DOWN = -27.0  # elevation of the cameras [deg]
_ROUNDS = 6


@dataclass(frozen=True, eq=False)
class Viewpoint:
    """A camera that looks at a point.

    Attributes:
        lookat: Point in the middle of the frame (3) [m].
        distance: Distance of the camera from that point [m].
        azimuth: Direction in which the camera looks, from +x towards +y [deg].
        elevation: Angle by which the camera looks up, negative to look down [deg].
    """

    lookat: Array
    distance: float
    azimuth: float
    elevation: float

    @classmethod
    def around(cls, points: Array, azimuth: float, aspect: float) -> Self:
        """The view in which points fill the frame.

        Args:
            points: Points (k, 3) [m].
            azimuth: Direction in which the camera looks, from +x towards +y [deg].
            aspect: Width of the frame in parts of its height.
        """
        right, up, forward = _camera_axes(np.radians(azimuth), np.radians(_DOWN))
        tall = _FILLED * float(np.tan(np.radians(FIELD_OF_VIEW / 2)))
        lookat, distance = (points.min(axis=0) + points.max(axis=0)) / 2, 1.0
        for _ in range(_ROUNDS):
            x, y, z = (points - lookat) @ right, (points - lookat) @ up, (points - lookat) @ forward
            distance = float((np.maximum(np.abs(x) / aspect, np.abs(y)) / tall - z).max())
            seen = np.stack([x, y]) / (distance + z)
            across, above = (seen.max(axis=1) + seen.min(axis=1)) / 2
            lookat = lookat + distance * (across * right + above * up)
        return cls(lookat, distance, azimuth, _DOWN)

    @classmethod
    def of_task(cls, patch: SurfacePatch | None, overlay: Sequence[OverlayItem], aspect: float) -> Self:
        """The view of a task: the contact and the arm beside it, or the whole arm and its reference path.

        Args:
            patch: Elastic surface; None in free space.
            overlay: Overlay of the frame, of which the paths count.
            aspect: Width of the frame in parts of its height.
        """
        if patch is not None:
            points = np.concatenate([_patch_points(patch, 1.05), _POST[1:], [_slide_housing(patch)]])
            return cls.around(points, _beside(patch), aspect)
        paths = [item.points for item in overlay if isinstance(item, Path)]
        if not paths:
            return cls.around(np.concatenate([_POST, _WORKSPACE]), 130.0, aspect)
        path = np.concatenate(paths)
        middle = path.mean(axis=0)
        toward = float(np.degrees(np.arctan2(middle[1], middle[0]))) + _ASIDE
        return cls.around(np.concatenate([_POST, path, _slide_ends(path)]), toward + 180.0, aspect)

    @classmethod
    def of_contact(cls, patch: SurfacePatch, aspect: float) -> Self:
        """A close view of the contact; `aspect` is the width of the frame in parts of its height."""
        return cls.around(_patch_points(patch, 0.6), _beside(patch), aspect)

    @classmethod
    def of_tip(cls, tip: Array, aspect: float) -> Self:
        """A close view of the tip, at a position (3) [m]; `aspect` as in `of_contact`."""
        return cls.around(tip + _NEAR_TIP * _CORNERS, 130.0, aspect)

    def set_camera(self, camera: mujoco.MjvCamera) -> None:
        """Set a free camera to this view."""
        camera.type = int(mujoco.mjtCamera.mjCAMERA_FREE)
        camera.lookat[:] = self.lookat
        camera.distance, camera.azimuth, camera.elevation = self.distance, self.azimuth, self.elevation


def _camera_axes(azimuth: float, elevation: float) -> tuple[Array, Array, Array]:
    """Unit vectors to the right, up and forward (3) of a camera, from its direction [rad]."""
    sine, cosine = np.sin(azimuth), np.cos(azimuth)
    forward = np.array([np.cos(elevation) * cosine, np.cos(elevation) * sine, np.sin(elevation)])
    right = np.array([sine, -cosine, 0.0])
    return right, np.cross(right, forward), forward


def _patch_points(patch: SurfacePatch, share: float) -> Array:
    """Points around the contact, on a share of the patch and before and behind it (8, 3) [m]."""
    size = share * HALF_SIZE
    points: Array = patch.center + (_CORNERS * (size, size, 0.4 * size)) @ patch.axes.T
    return points


def _beside(patch: SurfacePatch) -> float:
    """Direction of a camera beside the surface, on its free side and away from the base [deg]."""
    normal = patch.axes[:, 2] * (1.0, 1.0, 0.0)
    size = float(np.sqrt(normal @ normal))
    normal = normal / size if size > 1e-3 else np.array([0.0, -1.0, 0.0])  # a level surface has no side
    side = np.array([-normal[1], normal[0], 0.0])
    side *= 1.0 if side @ patch.center >= 0.0 else -1.0
    away = np.cos(np.radians(_BESIDE)) * side + np.sin(np.radians(_BESIDE)) * normal
    return float(np.degrees(np.arctan2(-away[1], -away[0])))


def _slide_ends(path: Array) -> Array:
    """About where the rear end of the slide is while the tip is on a path (k, 3) [m]."""
    angle = np.arctan2(path[:, 1], path[:, 0]) + np.radians(90.0)
    height = np.full_like(angle, _SLIDE_HEIGHT)
    return np.stack([_SLIDE_RADIUS * np.cos(angle), _SLIDE_RADIUS * np.sin(angle), height], axis=-1)


def _slide_housing(patch: SurfacePatch) -> Array:
    """Point of the slide beside the base (3) [m], where the slide is perpendicular to the surface."""
    normal = patch.axes[:, 2]
    point: Array = patch.center - (normal @ patch.center) * normal
    return point
