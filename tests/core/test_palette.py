"""The palette: eight colours that stay different under colour blindness."""

import itertools

import numpy as np
from matplotlib.colors import to_rgb

from prp_gym.palette import PALETTE

# of linear RGB, deuteranopia and protanopia, severity 1. Source: Machado, Oliveira, Fernandes 2009, table 1
DEUTERANOPIA = [
    [0.367322, 0.860646, -0.227968],
    [0.280085, 0.672501, 0.047413],
    [-0.011820, 0.042940, 0.968881],
]
PROTANOPIA = [
    [0.152286, 1.052583, -0.204868],
    [0.114503, 0.786281, 0.099216],
    [-0.003882, -0.048116, 1.051998],
]


def linear(color: str) -> np.ndarray:
    value = np.array(to_rgb(color))
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)


def test_colours_differ_for_every_kind_of_colour_vision() -> None:
    assert len(set(PALETTE)) == 8
    for matrix in (np.eye(3), np.array(DEUTERANOPIA), np.array(PROTANOPIA)):
        seen = [matrix @ linear(color) for color in PALETTE]
        nearest = min(float(np.linalg.norm(one - other)) for one, other in itertools.combinations(seen, 2))
        assert nearest > 0.05  # well above a step of 8 bits, 0.004
