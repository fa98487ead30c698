"""`StripChart`: a chart of some signals that runs with the time."""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from prp_gym.palette import BLACK, GRAY, LIGHT_GRAY
from prp_gym.robot.arrays import Array

if TYPE_CHECKING:
    from PIL.ImageDraw import ImageDraw

_STEPS = (1.0, 2.0, 5.0, 10.0)
_DASH = 7  # [pixels]


@dataclass(frozen=True)
class Trace:
    """A signal of a chart.

    Attributes:
        label: Name of the signal.
        color: Colour as a hexadecimal number.
        dashed: Whether the line is dashed, as what is desired is.
        values: Values so far (k), NaN where there is none.
    """

    label: str
    color: str
    dashed: bool
    values: Array


@dataclass(frozen=True)
class StripChart:
    """A chart in a rectangle of an image.

    Attributes:
        left: Left edge [pixels].
        top: Upper edge [pixels].
        width: Width [pixels].
        height: Height [pixels].
        duration: Time at the right edge [s].
        largest: Value at the upper line, below the title.
        title: What is drawn, with its unit.
    """

    left: int
    top: int
    width: int
    height: int
    duration: float
    largest: float
    title: str

    def draw(self, image: "ImageDraw", font: Any, time: Array, traces: Sequence[Trace]) -> None:
        """Draw the chart.

        Args:
            image: Image to draw into.
            font: Font of the texts.
            time: Times of the values (k) [s].
            traces: Signals.
        """
        right, bottom = self.left + self.width, self.top + self.height
        image.rectangle((self.left, self.top, right, bottom), outline=GRAY, fill="#FFFFFF")
        upper = min(self.top + 3 + sum(font.getmetrics()), self.top + self.height // 2)
        for y in (upper, (upper + bottom) // 2):
            image.line((self.left + 1, y, right - 1, y), fill=LIGHT_GRAY)
        for trace in traces:
            self._draw_trace(image, time, trace, upper)
        now = self._x(time[-1])
        image.line((now, upper, now, bottom), fill=GRAY)
        texts = ((self.title, "la", self.top + 3), (f"{self.largest:g}", "ra", self.top + 3))
        for text, anchor, y in texts:
            x = self.left + 5 if anchor == "la" else right - 5
            image.text((x, y), text, fill=BLACK, font=font, anchor=anchor)

    def _draw_trace(self, image: "ImageDraw", time: Array, trace: Trace, upper: int) -> None:
        """Draw a signal below the title, which ends at `upper` [pixels]."""
        shown = np.isfinite(trace.values)
        if not shown.any():
            return
        x = np.array([self._x(moment) for moment in time[shown]])
        share = np.clip(trace.values[shown] / self.largest, 0.0, 1.0)
        bottom = self.top + self.height - 1
        y = bottom - share * (bottom - upper)
        columns, last = np.unique(x.astype(int)[::-1], return_index=True)
        points = list(zip(columns.tolist(), y[::-1][last].tolist(), strict=True))
        thick = max(2, self.height // 40)
        for start, end in itertools.pairwise(points):
            if not trace.dashed or start[0] // _DASH % 2 == 0:
                image.line((*start, *end), fill=trace.color, width=thick)

    def _x(self, moment: float) -> int:
        return self.left + round(min(moment / self.duration, 1.0) * self.width)


def nice_limit(largest: float) -> float:
    """The least of 1, 2 and 5 times the powers of ten that is at least a value; 1 for 0 and NaN."""
    if not largest > 0.0 or not math.isfinite(largest):
        return 1.0
    power = 10.0 ** math.floor(math.log10(largest))
    return next(step * power for step in _STEPS if step * power >= largest * (1.0 - 1e-12))
