"""`ContactRing`: the phase of contact, as a ring around the tip and a word."""

from dataclasses import dataclass

import numpy as np

from prp_gym.drawing.canvas import Canvas
from prp_gym.drawing.overlay import OverlayItem
from prp_gym.palette import BLACK, VERMILLION, Color, rgba
from prp_gym.robot.arrays import Array

FREE, TOUCHING, LOST = "free", "touching", "contact lost"
"""Phases of contact: not yet touched, in touch, and out of touch after a contact."""

_RADIUS = 0.05  # [m]
_PIECES = {FREE: 0, TOUCHING: 32, LOST: 16}
_COLORS: dict[str, Color] = {FREE: rgba(BLACK), TOUCHING: rgba(BLACK), LOST: rgba(VERMILLION)}


@dataclass(frozen=True, eq=False)
class ContactRing(OverlayItem):
    """A solid ring in contact, a dashed one after a lost contact, and none before the first contact.

    Attributes:
        center: Position of the tip (3) [m].
        normal: Unit normal of the ring (3).
        phase: Phase of contact: `free`, `touching` or `contact lost`.
    """

    center: Array
    normal: Array
    phase: str

    def draw(self, canvas: Canvas) -> None:
        """See `OverlayItem.draw`."""
        count, color = _PIECES[self.phase], _COLORS[self.phase]
        across = np.cross(self.normal, (0.0, 0.0, 1.0) if abs(self.normal[2]) < 0.9 else (1.0, 0.0, 0.0))
        across /= np.sqrt(across @ across)
        up = np.cross(across, self.normal)
        angle = np.linspace(0.0, 2.0 * np.pi, count + 1)[:, None]
        points = self.center + _RADIUS * (np.cos(angle) * across + np.sin(angle) * up)
        step = 2 if self.phase == LOST else 1
        for start, end in zip(points[:-1:step], points[1::step], strict=True):
            canvas.line(start, end, 2.5, color)
        canvas.label(self.center - 1.6 * _RADIUS * up, self.phase)
