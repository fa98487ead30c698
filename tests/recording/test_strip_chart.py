"""Strip charts: where values stand in them."""

import math
from typing import Any

import numpy as np
import pytest
from PIL import Image, ImageDraw, ImageFont

from prp_gym.recording.strip_chart import StripChart, Trace, nice_limit


@pytest.mark.parametrize(
    ("largest", "limit"),
    [
        (0.0, 1.0),
        (math.nan, 1.0),
        (0.7, 1.0),
        (1.0, 1.0),
        (1.1, 2.0),
        (4.2, 5.0),
        (5.1, 10.0),
        (230.0, 500.0),
    ],
)
def test_limit_is_a_round_number_that_holds_the_values(largest: float, limit: float) -> None:
    assert nice_limit(largest) == pytest.approx(limit)


def test_trace_stands_at_its_time_and_value() -> None:
    image = Image.new("RGB", (220, 120), "#FFFFFF")
    time = np.linspace(0.0, 1.0, 200)
    values = np.where(time < 0.5, 2.0, 8.0)
    chart = StripChart(10, 10, 200, 100, 2.0, 10.0, "force [N]")
    font: Any = ImageFont.load_default(8)
    chart.draw(ImageDraw.Draw(image), font, time, [Trace("f", "#FF0000", False, values)])
    red = np.argwhere((np.asarray(image) == (255, 0, 0)).all(axis=-1))
    early, late = red[red[:, 1] < 55, 0], red[red[:, 1] > 65, 0]
    # what the title leaves of 100 pixels is 10 N, from below; the line is two pixels thick
    rest = 100 - 3 - sum(font.getmetrics())
    assert early.mean() == pytest.approx(110 - 0.2 * rest, abs=2)
    assert late.mean() == pytest.approx(110 - 0.8 * rest, abs=2)
    assert red[:, 1].max() == pytest.approx(110, abs=2)  # 1 s of 2 s
    assert red[:, 1].min() == pytest.approx(10, abs=2)


def test_desired_values_are_dashed_and_missing_ones_not_drawn() -> None:
    shares = {}
    for dashed in (False, True):
        image = Image.new("RGB", (220, 120), "#FFFFFF")
        chart = StripChart(10, 10, 200, 100, 1.0, 10.0, "")
        time = np.linspace(0.0, 1.0, 400)
        traces = [
            Trace("f_d", "#0000FF", dashed, np.full(400, 5.0)),
            Trace("f", "#00FF00", False, np.full(400, np.nan)),
        ]
        chart.draw(ImageDraw.Draw(image), ImageFont.load_default(8), time, traces)
        frame = np.asarray(image)
        shares[dashed] = (frame == (0, 0, 255)).all(axis=-1).any(axis=0)[12:205].mean()
        assert not (frame == (0, 255, 0)).all(axis=-1).any()
    assert shares[False] > 0.98
    assert 0.3 < shares[True] < 0.7
