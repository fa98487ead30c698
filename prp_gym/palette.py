"""The colours of frames, videos and plots, which readers with a colour vision deficiency can tell apart.

Every use has a second cue beside its colour: a line style, a marker or a shape.

Source: Okabe 2008.
"""

from typing import NamedTuple

Color = tuple[float, float, float, float]
"""Red, green, blue and opacity, each from 0 to 1."""

BLACK = "#000000"
ORANGE = "#E69F00"
SKY_BLUE = "#56B4E9"
BLUISH_GREEN = "#009E73"
YELLOW = "#F0E442"
BLUE = "#0072B2"
VERMILLION = "#D55E00"
REDDISH_PURPLE = "#CC79A7"
PALETTE = (BLACK, ORANGE, SKY_BLUE, BLUISH_GREEN, YELLOW, BLUE, VERMILLION, REDDISH_PURPLE)
"""All colours, in the order of their authors."""

GRAY = "#777777"
LIGHT_GRAY = "#DDDDDD"

REFERENCE = BLUE
"""What is desired: reference, goal, desired force; drawn translucent or dashed."""

MEASURED = ORANGE
"""What the tip has done: its trail; drawn solid."""

FORCE = VERMILLION
"""Contact force; drawn solid."""

SURFACE = BLUISH_GREEN
"""The elastic surface and the contact with it."""


class Style(NamedTuple):
    """How one series of a plot is drawn.

    Attributes:
        color: Colour as a hexadecimal number.
        line: Line style in matplotlib's notation.
        marker: Marker in matplotlib's notation.
    """

    color: str
    line: str
    marker: str


SERIES = (
    Style(BLUE, "-", "o"),
    Style(VERMILLION, "--", "s"),
    Style(BLUISH_GREEN, "-.", "^"),
    Style(REDDISH_PURPLE, ":", "D"),
    Style(ORANGE, "-", "v"),
    Style(SKY_BLUE, "--", "P"),
    Style(BLACK, "-.", "X"),
    Style(YELLOW, ":", "*"),
)
"""Styles of series that have no meaning of their own, in the order of their use."""


def series_style(index: int) -> Style:
    """Style of a series by its position; where colours repeat, line and marker differ.

    Args:
        index: Position of the series, from 0.
    """
    round_, position = divmod(index, len(SERIES))
    shifted = SERIES[(position + round_) % len(SERIES)]
    return Style(SERIES[position].color, shifted.line, shifted.marker)


def rgba(color: str, opacity: float = 1.0) -> Color:
    """Numbers of a colour.

    Args:
        color: Colour as a hexadecimal number, such as `#0072B2`.
        opacity: Opacity, from 0 to 1.
    """
    red, green, blue = (int(color[start : start + 2], 16) / 255.0 for start in (1, 3, 5))
    return red, green, blue, opacity


def rgb(color: str) -> tuple[int, int, int]:
    """Red, green and blue of a colour, each from 0 to 255.

    Args:
        color: Colour as a hexadecimal number.
    """
    return int(color[1:3], 16), int(color[3:5], 16), int(color[5:7], 16)
