"""`SurfacePatch`: the drawn part of the elastic surface, with how far it gives under the tip."""

import itertools
from dataclasses import dataclass
from typing import Self

import mujoco
import numpy as np

from prp_gym.drawing.canvas import Canvas
from prp_gym.drawing.overlay import OverlayItem
from prp_gym.palette import BLACK, SURFACE, rgba
from prp_gym.robot.arrays import Array

HALF_SIZE = 0.16
"""Half of the side of the patch [m]."""

BODY = "surface"
"""Name of the body of the surface in a model."""

_THICKNESS, _BAR = 0.024, 0.010  # of the edge, along and across the normal [m]
_WIDTH = 0.035  # of the dent, at least [m]
_FACE, _LINE, _EDGE = rgba(SURFACE, 0.55), rgba(BLACK, 0.55), rgba("#3A3F44")
_RAYS, _RINGS = (24, 6), (8, 3)  # of fine and of small frames
_SQUARE = np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0], [1.0, 1.0]])
_TO_FLOOR = 0.3  # z component of the normal up to which the patch stands on posts


@dataclass(frozen=True, eq=False)
class SurfacePatch(OverlayItem):
    """A square patch of the surface: an edge with a thickness, and a face that gives under the tip.

    The face touches the tip; the edge stays where the undeformed surface is. The shape of the dent is drawn
    and not computed: a spring has none.

    Attributes:
        center: Centre of the undeformed patch (3) [m].
        axes: Axes of the patch in the world, as columns (3, 3); the third is the normal to the free side.
        contact: Position of the tip along the first two axes (2) [m].
        depth: Indentation by the tip [m], 0 without contact.
        floor: Height of the floor [m], on which the patch stands.
    """

    center: Array
    axes: Array
    contact: Array
    depth: float
    floor: float

    @classmethod
    def of(cls, model: mujoco.MjModel, data: mujoco.MjData) -> Self | None:
        """The patch of a state of a world; None in a world without a surface."""
        body = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, BODY)
        if body < 0:
            return None
        center, axes = np.array(data.xpos[body]), np.array(data.xmat[body]).reshape(3, 3)
        tip = model.geom("tip")
        local = axes.T @ (data.geom_xpos[tip.id] - center)
        depth = max(0.0, float(tip.size[0] - local[2]))
        return cls(center, axes, local[:2], depth, float(model.geom("floor").pos[2]))

    def draw(self, canvas: Canvas) -> None:
        """See `OverlayItem.draw`."""
        self._draw_edge(canvas)
        rays, rings = _RAYS if canvas.fine else _RINGS
        grid = self._face(rays, rings)
        beside = np.roll(grid, -1, axis=1)
        first = np.stack([grid[:-1], grid[1:], beside[1:]], axis=2)
        second = np.stack([grid[:-1], beside[1:], beside[:-1]], axis=2)
        canvas.mesh(np.concatenate([first, second]).reshape(-1, 3, 3), _FACE)
        if canvas.fine:
            self._draw_lines(canvas, grid)

    def _face(self, rays: int, rings: int) -> Array:
        """Points of the face (rings + 1, rays, 3) [m], on rays from the contact to the edge."""
        inside = bool((np.abs(self.contact) < 0.95 * HALF_SIZE).all())
        start = self.contact if inside else np.zeros(2)
        rim = _rim(rays)
        reach = np.sqrt(np.square(rim - start).sum(axis=-1))
        share = (np.arange(rings + 1) / rings)[:, None] ** 1.7
        radius = share * reach
        flat = start + share[..., None] * (rim - start)
        width = max(_WIDTH, 0.5 * self.depth)
        dent = (1.0 - share**2) ** 2 / (1.0 + (radius / width) ** 2) * (self.depth if inside else 0.0)
        points: Array = self.center + flat @ self.axes[:, :2].T - dent[..., None] * self.axes[:, 2]
        return points

    def _draw_lines(self, canvas: Canvas, grid: Array) -> None:
        """Rings and rays on the face, by which the shape of the dent is seen."""
        closed = np.concatenate([grid, grid[:, :1]], axis=1)
        for ring in closed[1:-1]:
            for start, end in itertools.pairwise(ring):
                canvas.line(start, end, 0.7, _LINE)
        for ray in range(0, grid.shape[1], 2):
            for start, end in zip(grid[:-1, ray], grid[1:, ray], strict=True):
                canvas.line(start, end, 0.7, _LINE)

    def _draw_edge(self, canvas: Canvas) -> None:
        """Four bars around the face, on posts where the surface is upright."""
        u, v, normal = self.axes.T
        back = self.center - 0.5 * _THICKNESS * normal
        half = HALF_SIZE + _BAR
        for side in (-half, half):
            thick = _THICKNESS / 2
            canvas.box(back + side * v, np.array([half - _BAR, _BAR, thick]), self.axes, _EDGE)
            canvas.box(back + side * u, np.array([_BAR, half + _BAR, thick]), self.axes, _EDGE)
        if abs(normal[2]) < _TO_FLOOR:
            self._draw_posts(canvas, back, half)

    def _draw_posts(self, canvas: Canvas, back: Array, half: float) -> None:
        corners = [
            back + half * (a * self.axes[:, 0] + b * self.axes[:, 1]) for a in (-1, 1) for b in (-1, 1)
        ]
        for corner in sorted(corners, key=lambda point: float(point[2]))[:2]:
            if corner[2] > self.floor:
                canvas.rod(corner, np.array([*corner[:2], self.floor]), _BAR, _EDGE)


def _rim(rays: int) -> Array:
    """Points on the rim of the face (rays, 2) [m], with the corners if the number can be divided by four."""
    at = np.arange(rays) * 4.0 / rays
    side = at.astype(int)
    share = (at - side)[:, None]
    rim: Array = HALF_SIZE * ((1.0 - share) * _SQUARE[side] + share * _SQUARE[side + 1])
    return rim
