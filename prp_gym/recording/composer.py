"""`Composer`: puts frames, numbers and strip charts into the frames of a video."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from prp_gym.extras import check
from prp_gym.palette import BLACK, FORCE, GRAY, MEASURED, REFERENCE
from prp_gym.recording.side import Side
from prp_gym.recording.signals import Sample
from prp_gym.recording.strip_chart import StripChart, Trace, nice_limit
from prp_gym.robot.arrays import Array

_HEADER, _CHARTS = 0.13, 0.24  # of the height
_MARGIN = 6  # [pixels]
_LEAST_LIMIT = 1.0  # of a chart, in its unit


class Composer:
    """Composes frames of one size.

    Args:
        width: Width of an image [pixels].
        height: Height of an image [pixels].
        sides: Number of episodes beside each other.
        title: Line above all of them.
        duration: Duration of the episode, at the right edge of the charts [s].

    Raises:
        MissingPackageError: Pillow is not installed.
    """

    def __init__(self, width: int, height: int, sides: int, title: str, duration: float) -> None:
        check("PIL")
        from PIL import ImageFont  # on use: the package stays light

        self._size, self._title, self._duration = (width, height), title, duration
        self._column = width // sides
        self._top, self._chart_height = round(_HEADER * height), round(_CHARTS * height)
        self._line, self._load = max(9.0, 0.034 * height), ImageFont.load_default
        self._small = ImageFont.load_default(max(8.0, 0.026 * height))

    @property
    def frame_size(self) -> tuple[int, int]:
        """Width and height of one episode's frames [pixels]."""
        return self._column, self._size[1] - self._top - self._chart_height

    def compose(self, sides: Sequence[Side]) -> NDArray[np.uint8]:
        """An image (height, width, 3) of the present moment of every episode."""
        from PIL import Image, ImageDraw

        image = Image.new("RGB", self._size, "#FFFFFF")
        for index, side in enumerate(sides):
            image.paste(Image.fromarray(side.frame()), (index * self._column, self._top))
        draw = ImageDraw.Draw(image)
        draw.text((_MARGIN, 2), self._title, fill=BLACK, font=self._small)
        limits = [nice_limit(_largest(sides, names)) for names in (("force", "desired_force"), ("error",))]
        for index, side in enumerate(sides):
            left = index * self._column
            for line, y in ((side.name, 0.30), (numbers(side), 0.64)):
                corner = (left + _MARGIN, round(y * self._top))
                draw.text(corner, line, fill=BLACK, font=self._fitted(line))
            self._draw_charts(draw, left, side, limits)
        if len(sides) > 1:
            draw.line((self._column, self._top // 2, self._column, self._size[1]), fill=GRAY, width=2)
        return np.asarray(image)

    def _fitted(self, text: str) -> Any:
        """A font in which a line of text fits above an episode."""
        room = self._column - 2 * _MARGIN
        return self._load(min(self._line, self._line * room / self._load(self._line).getlength(text)))

    def _draw_charts(self, draw: Any, left: int, side: Side, limits: Sequence[float]) -> None:
        values = np.array(side.samples)
        charts: list[tuple[str, float, list[Trace]]] = []
        if np.isfinite(values[:, 1]).any():
            title = "contact force f, desired f_d (dashed) [N]"
            if not np.isfinite(values[:, 2]).any():
                title = "contact force f [N]"
            traces = [Trace("f_d", REFERENCE, True, values[:, 2]), Trace("f", FORCE, False, values[:, 1])]
            charts.append((title, limits[0], traces))
        title = f"{side.error.name} [{side.error.unit}]"
        charts.append((title, limits[1], [Trace("error", MEASURED, False, values[:, 3])]))
        height = self._chart_height // len(charts) - _MARGIN
        for row, (title, limit, traces) in enumerate(charts):
            top = self._size[1] - self._chart_height + row * (height + _MARGIN) + _MARGIN // 2
            box = (left + _MARGIN, top, self._column - 2 * _MARGIN, height)
            StripChart(*box, self._duration, limit, title).draw(draw, self._small, values[:, 0], traces)


def numbers(side: Side) -> str:
    """The line of an episode: time, force and error."""
    now: Sample = side.samples[-1]
    parts = [f"t {now.time:.2f} s"]
    if np.isfinite(now.force):
        parts.append(f"f {now.force:.2f} N")
    if np.isfinite(now.desired_force):
        parts.append(f"f_d {now.desired_force:.2f} N")
    parts.append(f"{side.error.name} {now.error:.1f} {side.error.unit}")
    return "   ".join(parts)


def _largest(sides: Sequence[Side], names: Sequence[str]) -> float:
    """The largest value of some signals of all episodes so far, at least `_LEAST_LIMIT`."""
    columns = [Sample._fields.index(name) for name in names]
    found: Array = np.concatenate([np.array(side.samples)[:, columns].ravel() for side in sides])
    finite = found[np.isfinite(found)]
    return max(_LEAST_LIMIT, float(finite.max())) if finite.size else _LEAST_LIMIT
