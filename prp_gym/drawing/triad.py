"""`Triad`: the axes of a frame."""

import math
from dataclasses import dataclass

import numpy as np

from prp_gym.drawing.canvas import Canvas
from prp_gym.drawing.overlay import OverlayItem
from prp_gym.palette import Color
from prp_gym.robot.arrays import Array


@dataclass(frozen=True, eq=False)
class Triad(OverlayItem):
    """The three axes of a frame, as arrows of one colour and of rising length x, y, z.

    Attributes:
        origin: Origin of the frame in the world (3) [m].
        axes: Axes of the frame in the world, as columns (3, 3).
        length: Length of the z axis [m].
        width: Radius of the axes [m].
        color: Colour of the axes.
        names: Names of the axes (3), or none.
    """

    origin: Array
    axes: Array
    length: float
    width: float
    color: Color
    names: tuple[str, ...] = ()

    def draw(self, canvas: Canvas) -> None:
        """See `OverlayItem.draw`."""
        ends = [
            self.origin + share * self.length * axis for share, axis in zip(_SHARES, self.axes.T, strict=True)
        ]
        if not canvas.fine:
            for end in ends:
                canvas.line(self.origin, end, 500.0 * self.width, self.color)
            return
        canvas.ball(self.origin, 2.0 * self.width, self.color)
        for end in ends:
            canvas.arrow(self.origin, end, self.width, self.color)
        for end, name in zip(ends, self.names, strict=False):
            canvas.label(end, name)


def tip_axes(angles: Array) -> Array:
    """Axes of the end-effector frame at the angles α, β, γ of a pose (3) [rad], as columns (3, 3)."""
    alpha, beta, gamma = angles.tolist()
    return _about_z(alpha - math.pi / 2) @ _about_y(beta) @ _about_z(gamma + math.pi / 2)


def _about_z(angle: float) -> Array:
    cosine, sine = math.cos(angle), math.sin(angle)
    return np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])


def _about_y(angle: float) -> Array:
    cosine, sine = math.cos(angle), math.sin(angle)
    return np.array([[cosine, 0.0, sine], [0.0, 1.0, 0.0], [-sine, 0.0, cosine]])


_SHARES = (0.6, 0.8, 1.0)
"""Lengths of the axes x, y, z in parts of that of the z axis, which points along the third link."""
