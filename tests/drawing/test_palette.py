"""The palette: colours that can be told apart with deuteranopia, and a second cue beside each of them."""

import itertools

import numpy as np
import pytest

from docs.colour_vision import simulate
from prp_gym.drawing.palette import (
    FORCE,
    MEASURED,
    REFERENCE,
    SERIES,
    SURFACE,
    rgb,
    rgba,
    series_style,
)
from prp_gym.robot.arrays import Array

MEANINGS = (REFERENCE, MEASURED, FORCE, SURFACE)


def seen(color: str) -> Array:
    """A colour as it is seen with deuteranopia."""
    return np.array(simulate(np.array([[rgb(color)]], dtype=np.uint8))[0, 0], dtype=np.float64)


@pytest.mark.parametrize("colors", list(itertools.combinations(MEANINGS, 2)))
def test_colours_with_a_meaning_differ_with_deuteranopia(colors: tuple[str, str]) -> None:
    # pure red and pure green of equal lightness, which nobody with deuteranopia tells apart, are 15 apart
    assert np.abs(seen(colors[0]) - seen(colors[1])).max() > 40.0


def test_deuteranopia_leaves_grey_and_brings_red_and_green_together() -> None:
    for level in (0, 60, 180, 255):
        grey = np.full((1, 1, 3), level, dtype=np.uint8)
        np.testing.assert_allclose(simulate(grey), grey, atol=1)  # rows of the matrix sum to 1
    red, green = "#C04000", "#708000"
    before = np.abs(np.array(rgb(red)) - rgb(green)).max()
    assert np.abs(seen(red) - seen(green)).max() < 0.5 * before


def test_series_differ_in_colour_and_in_marker() -> None:
    assert len({style.color for style in SERIES}) == len(SERIES)
    assert len({style.marker for style in SERIES}) == len(SERIES)
    assert all(one.line != other.line for one, other in itertools.pairwise(SERIES))


def test_series_beyond_the_palette_differ_from_those_before() -> None:
    styles = [series_style(index) for index in range(3 * len(SERIES))]
    assert len(set(styles)) == len(styles)
    assert styles[: len(SERIES)] == list(SERIES)


def test_numbers_of_a_colour() -> None:
    assert rgb("#D55E00") == (213, 94, 0)
    assert rgba("#FF0080", 0.5) == (1.0, 0.0, 128 / 255, 0.5)
