"""The items of an overlay: what frames show beside the robot and its surroundings."""

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from prp_gym.drawing.canvas import Canvas
from prp_gym.palette import Color
from prp_gym.robot.arrays import Array


class OverlayItem(ABC):
    """Something that frames show beside the robot and its surroundings."""

    @abstractmethod
    def draw(self, canvas: Canvas) -> None:
        """Add the item to a scene."""


@dataclass(frozen=True, eq=False)
class Ball(OverlayItem):
    """A ball in the world frame.

    Attributes:
        center: Centre of the ball (3) [m].
        radius: Radius of the ball [m].
        color: Colour of the ball.
    """

    center: Array
    radius: float
    color: Color

    def draw(self, canvas: Canvas) -> None:
        """See `OverlayItem.draw`."""
        canvas.ball(self.center, self.radius, self.color)


@dataclass(frozen=True, eq=False)
class Path(OverlayItem):
    """A dashed line through points in the world frame.

    Attributes:
        points: Points of the path (k, 3) [m].
        width: Width of the line in pixels of a frame 480 pixels high.
        color: Colour of the line.
    """

    points: Array
    width: float
    color: Color

    def draw(self, canvas: Canvas) -> None:
        """See `OverlayItem.draw`."""
        along = np.concatenate(
            [[0.0], np.cumsum(np.sqrt(np.square(np.diff(self.points, axis=0)).sum(axis=1)))]
        )
        dash, pieces = (_DASH, 2) if canvas.fine else (3 * _DASH, 1)
        count = int(np.clip(along[-1] / dash, 1, _MOST_DASHES))
        at = np.linspace(0.0, along[-1], 2 * pieces * count + 1)
        points = np.stack([np.interp(at, along, column) for column in self.points.T], axis=-1)
        for index in (index for index in range(len(at) - 1) if index // pieces % 2 == 0):
            canvas.line(points[index], points[index + 1], self.width, self.color)


@dataclass(frozen=True, eq=False)
class Arrow(OverlayItem):
    """A solid arrow in the world frame, with a text at its free end.

    Attributes:
        start: Point where the arrow begins (3) [m].
        vector: Vector from there to its head (3) [m].
        width: Radius of the shaft [m].
        color: Colour of the arrow.
        text: Text beside the arrow; empty for none.
        labelled: Share of the arrow's length at which the text stands, 0 at its start and 1 at its head.
    """

    start: Array
    vector: Array
    width: float
    color: Color
    text: str = ""
    labelled: float = 1.0

    def draw(self, canvas: Canvas) -> None:
        """See `OverlayItem.draw`."""
        canvas.arrow(self.start, self.start + self.vector, self.width, self.color)
        self._write(canvas)

    def _write(self, canvas: Canvas) -> None:
        if self.text:
            canvas.label(self.start + self.labelled * self.vector + _ABOVE, self.text)


@dataclass(frozen=True, eq=False)
class DashedArrow(Arrow):
    """An arrow with a dashed shaft, for what is desired."""

    def draw(self, canvas: Canvas) -> None:
        """See `OverlayItem.draw`."""
        ends = np.linspace(0.0, 1.0 - _HEAD, _DASHES)
        for start, end in zip(ends[:-1:2], ends[1::2], strict=True):
            canvas.rod(
                self.start + start * self.vector, self.start + end * self.vector, self.width / 2, self.color
            )
        canvas.arrow(self.start + ends[-1] * self.vector, self.start + self.vector, self.width, self.color)
        self._write(canvas)


_DASHES = 6  # ends of the pieces of a dashed shaft
_HEAD = 0.4  # of the length of a dashed arrow
_ABOVE = np.array([0.0, 0.0, 0.03])  # of a text over its arrow [m]
_DASH = 0.03  # of a path, with the gap that follows [m]
_MOST_DASHES = 150
