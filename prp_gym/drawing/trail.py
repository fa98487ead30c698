"""`Trail`: where the tip was a moment ago."""

from dataclasses import dataclass

import numpy as np

from prp_gym.drawing.canvas import Canvas
from prp_gym.drawing.overlay import OverlayItem
from prp_gym.palette import MEASURED, rgba
from prp_gym.robot.arrays import Array

_RADIUS = 0.0045  # [m], at the tip
_LEAST = 0.25  # of the radius and of the opacity, at the oldest point
_LONGEST_PIECE = 0.015  # [m]
_MOST_PIECES = 100


@dataclass(frozen=True, eq=False)
class Trail(OverlayItem):
    """A solid line that fades with age.

    Attributes:
        points: Positions of the tip (k, 3) [m], the oldest first.
    """

    points: Array

    def draw(self, canvas: Canvas) -> None:
        """See `OverlayItem.draw`."""
        points = smooth(self.points) if canvas.fine else self.points[::-3][::-1]
        ages = np.linspace(_LEAST, 1.0, len(points))
        for start, end, share in zip(points[:-1], points[1:], ages[1:].tolist(), strict=True):
            if canvas.fine:
                canvas.rod(start, end, share * _RADIUS, rgba(MEASURED, share))
            else:
                canvas.line(start, end, 2.0, rgba(MEASURED, share))


def smooth(points: Array) -> Array:
    """Points (m, 3) on a Catmull-Rom spline through points (k, 3), so dense that no corner is seen."""
    if len(points) < 3:
        return points
    ends = np.concatenate([2 * points[:1] - points[1:2], points, 2 * points[-1:] - points[-2:-1]])
    longest = float(np.abs(np.diff(points, axis=0)).max())
    count = int(np.clip(np.ceil(longest / _LONGEST_PIECE), 1, _MOST_PIECES / len(points) + 1))
    before, start, end, after = ends[:-3], ends[1:-2], ends[2:-1], ends[3:]
    u = (np.arange(count) / count)[:, None, None]
    curve = 0.5 * (
        2 * start
        + (end - before) * u
        + (2 * before - 5 * start + 4 * end - after) * u**2
        + (3 * start - before - 3 * end + after) * u**3
    )
    inside = curve.transpose(1, 0, 2).reshape(-1, 3)
    return np.concatenate([inside, points[-1:]])
