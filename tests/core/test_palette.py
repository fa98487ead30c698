"""The palette: colours that can be told apart with deuteranopia, and a second cue beside each of them."""

import itertools

import numpy as np
import pytest

from docs.colour_vision import DEUTERANOPIA, simulate
from prp_gym.palette import (
    FORCE,
    MEASURED,
    PALETTE,
    REFERENCE,
    SERIES,
    SURFACE,
    rgb,
    rgba,
    series_style,
)
from prp_gym.robot.arrays import Array

# of linear RGB, protanopia, severity 1. Source: Machado, Oliveira, Fernandes 2009, table 1
PROTANOPIA = [
    [0.152286, 1.052583, -0.204868],
    [0.114503, 0.786281, 0.099216],
    [-0.003882, -0.048116, 1.051998],
]
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


def linear(color: str) -> Array:
    """A colour in linear RGB."""
    value = np.array(rgb(color)) / 255.0
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)


def test_colours_differ_for_every_kind_of_colour_vision() -> None:
    assert len(set(PALETTE)) == 8
    for matrix in (np.eye(3), np.array(DEUTERANOPIA), np.array(PROTANOPIA)):
        found = [matrix @ linear(color) for color in PALETTE]
        nearest = min(float(np.linalg.norm(one - other)) for one, other in itertools.combinations(found, 2))
        assert nearest > 0.05  # well above a step of 8 bits, 0.004
