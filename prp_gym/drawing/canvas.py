"""`Canvas`: the geometric shapes that can be added to a MuJoCo scene."""

from typing import Any

import mujoco
import numpy as np

from prp_gym.palette import Color
from prp_gym.robot.arrays import Array

FINE = 240
"""Height of a frame [pixels] from which on it has labels, soft shadows and fine shapes."""

LEGIBLE = 360
"""Height of a frame [pixels] from which on there is room for the numbers of the floor's scale."""

_REFERENCE_HEIGHT = 480.0  # [pixels]: at this height of a frame, widths of lines are as they are given
_SHAPES = mujoco.mjtGeom
_DECOR, _DYNAMIC = int(mujoco.mjtCatBit.mjCAT_DECOR), int(mujoco.mjtCatBit.mjCAT_DYNAMIC)
_UNIT = np.eye(3).ravel()


class Canvas:
    """Adds shapes to a scene; those that exceed its capacity are left out.

    Args:
        model: Model of the robot, of which ghosts are drawn.
        scene: Scene to which shapes are added.
        height: Height of the frame [pixels], on which the fineness of shapes depends.
    """

    def __init__(self, model: mujoco.MjModel, scene: mujoco.MjvScene, height: int) -> None:
        self._model, self._scene = model, scene
        self._ghost: mujoco.MjData | None = None
        self._line_scale = max(1.0, height / _REFERENCE_HEIGHT)
        self.fine = height >= FINE
        self.legible = height >= LEGIBLE

    @property
    def forward(self) -> Array:
        """Direction in which the camera looks (3)."""
        return np.array(self._scene.camera[0].forward, dtype=np.float64)

    def ball(self, center: Array, radius: float, color: Color) -> None:
        """Add a ball with its centre (3) and radius [m]."""
        self._add(_SHAPES.mjGEOM_SPHERE, np.full(3, radius), center, _UNIT, color)

    def box(self, center: Array, half: Array, axes: Array, color: Color) -> None:
        """Add a box with its centre (3), half lengths (3) [m], and axes as columns (3, 3)."""
        self._add(_SHAPES.mjGEOM_BOX, half, center, axes.ravel(), color)

    def line(self, start: Array, end: Array, width: float, color: Color) -> None:
        """Add a line between two points (3) [m], with its width in pixels of a frame 480 pixels high."""
        self._connect(_SHAPES.mjGEOM_LINE, width * self._line_scale, start, end, color)

    def rod(self, start: Array, end: Array, radius: float, color: Color) -> None:
        """Add a rod with round ends between two points (3), with its radius [m]."""
        self._connect(_SHAPES.mjGEOM_CAPSULE, radius, start, end, color)

    def arrow(self, start: Array, end: Array, radius: float, color: Color) -> None:
        """Add an arrow between two points (3), with the radius of its shaft [m]."""
        # MuJoCo draws an arrow half as long as the distance of its ends
        self._connect(_SHAPES.mjGEOM_ARROW, radius, start, start + 2.0 * (end - start), color)

    def mesh(self, corners: Array, color: Color) -> None:
        """Add triangles with their corners (k, 3, 3) [m], seen from both sides."""
        sides = corners[:, 1:] - corners[:, :1]
        lengths = np.sqrt(np.square(sides).sum(axis=-1))
        normals = np.cross(sides[:, 0], sides[:, 1])
        sizes = np.sqrt(np.square(normals).sum(axis=-1))
        whole = sizes > 0.0
        axes = np.concatenate([sides / np.maximum(lengths, 1e-12)[..., None], normals[:, None]], axis=1)
        axes[whole, 2] /= sizes[whole, None]
        frames = axes.transpose(0, 2, 1).reshape(-1, 9)
        scales = np.concatenate([lengths, np.zeros((len(lengths), 1))], axis=1)
        for index in np.flatnonzero(whole):
            self._add(_SHAPES.mjGEOM_TRIANGLE, scales[index], corners[index, 0], frames[index], color)

    def label(self, point: Array, text: str) -> None:
        """Write a text at a point (3) [m]; small frames have no labels."""
        if self.fine:
            shape = self._add(_SHAPES.mjGEOM_LABEL, np.zeros(3), point, _UNIT, (1.0, 1.0, 1.0, 1.0))
            if shape is not None:
                shape.label = text

    def ghost(self, joint_position: Array, growth: float, color: Color) -> None:
        """Add the robot at other joint positions (joints), in one colour and grown on all sides [m]."""
        if self._ghost is None:
            self._ghost = mujoco.MjData(self._model)
        self._ghost.qpos[:] = joint_position
        mujoco.mj_kinematics(self._model, self._ghost)
        first = self._scene.ngeom
        mujoco.mjv_addGeoms(
            self._model, self._ghost, mujoco.MjvOption(), mujoco.MjvPerturb(), _DYNAMIC, self._scene
        )
        for shape in self._scene.geoms[first : self._scene.ngeom]:
            shape.rgba, shape.matid, shape.category = color, -1, _DECOR
            shape.size = shape.size + growth

    def _connect(self, kind: Any, width: float, start: Array, end: Array, color: Color) -> None:
        shape = self._add(kind, np.zeros(3), np.zeros(3), _UNIT, color)
        if shape is not None:
            mujoco.mjv_connector(shape, kind, width, np.asarray(start), np.asarray(end))

    def _add(self, kind: Any, size: Array, position: Array, axes: Array, color: Color) -> Any:
        scene = self._scene
        if scene.ngeom >= scene.maxgeom:
            return None
        shape = scene.geoms[scene.ngeom]
        scene.ngeom += 1
        center = np.asarray(position, dtype=np.float64)
        mujoco.mjv_initGeom(shape, kind, size, center, axes, np.array(color, dtype=np.float32))
        shape.category = _DECOR
        return shape
