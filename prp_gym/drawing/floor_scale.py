"""`FloorScale`: lines and numbers on the floor by which lengths can be read."""

from dataclasses import dataclass

import numpy as np

from prp_gym.drawing.canvas import Canvas
from prp_gym.drawing.overlay import OverlayItem
from prp_gym.palette import rgba

_COLOR = rgba("#4A4F55")
_ABOVE, _WIDTH, _THIN = 0.0005, 0.0025, 0.0005  # [m]
_NUMBERS = 2  # on either side of the base
_LABELS = 1.0  # distance of the numbers from the base, on the side away from the camera [m]
_SPACING = 0.5  # [m]
_LINES = 3  # on either side of the base


@dataclass(frozen=True, eq=False)
class FloorScale(OverlayItem):
    """Lines on the floor every half metre from the robot's base, with their distances.

    Attributes:
        height: Height of the floor [m].
    """

    height: float

    def draw(self, canvas: Canvas) -> None:
        """See `OverlayItem.draw`; small frames show the lines only, the smallest the squares of the floor."""
        if not canvas.fine:
            return
        end, z = _LINES * _SPACING, self.height + _ABOVE
        for index in range(-_LINES, _LINES + 1):
            at = index * _SPACING
            canvas.box(np.array([at, 0.0, z]), np.array([_WIDTH, end, _THIN]), np.eye(3), _COLOR)
            canvas.box(np.array([0.0, at, z]), np.array([end, _WIDTH, _THIN]), np.eye(3), _COLOR)
        if not canvas.legible:
            return
        behind = np.where(canvas.forward[:2] >= 0.0, _LABELS, -_LABELS)
        for index in range(-_NUMBERS, _NUMBERS + 1):
            canvas.label(np.array([index * _SPACING, behind[1], z]), f"x {index * _SPACING:g} m")
        for index in range(1 - _NUMBERS, _NUMBERS):
            canvas.label(np.array([behind[0], index * _SPACING, z]), f"y {index * _SPACING:g} m")
