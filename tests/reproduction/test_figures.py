"""Figures of the reproduction: what goes into which axes, and into the data beside it."""

import io
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from prp_gym.figures.figure_file import figure_content
from prp_gym.palette import rgb
from prp_gym.reproduction import FigureOutcome, Level, Panel, RecordedRun, Verdict, load_catalogue
from prp_gym.reproduction.figures import COLORS, axes_of, draw, table
from tests.support.synthetic_rollout import rollout_of

CATALOGUE = load_catalogue()
TIME = np.arange(5) * 0.1


def recorded(name: str, scale: float, steps: int = 4) -> RecordedRun:
    """A run whose joint i moves as scale (i + 1) t, towards 10 times that."""
    position = np.outer(TIME[: steps + 1], [1.0, 2.0, 3.0]) * scale
    torque = np.outer(np.arange(steps), [1.0, 10.0, 100.0])
    rollout = rollout_of({"joint_position": position, "desired_joint_position": 10 * position}, torque)
    return RecordedRun(replace(CATALOGUE.runs["pd"], name=name, label=f"run {name}"), rollout, {}, "hand")


def outcome(*panels: Panel, until: float = 0.4, steps: int = 4) -> FigureOutcome:
    """A figure of two runs, one check on joints 3 and 1."""
    check = CATALOGUE.experiments[6].checks[0]
    arguments = {"signal": "joint_position", "components": [2, 0]}
    check = replace(
        check, name="both", label="rest, predicted", measure=replace(check.measure, arguments=arguments)
    )
    numbers = np.array([7.0, 8.0])
    experiment = replace(CATALOGUE.experiments[6], panels=panels, until=until, checks=(check,))
    runs = {"a": recorded("a", 1.0), "b": recorded("b", -2.0, steps)}
    return FigureOutcome(experiment, runs, (Verdict(check, numbers, numbers, numbers, numbers),))


def test_each_component_has_its_axes_with_runs_and_reference() -> None:
    panel = Panel("joint_position", (2, 0), ("a", "b"), reference="desired_joint_position")
    third, first = axes_of(outcome(panel))
    assert (third.symbol, third.unit, first.symbol, first.unit) == ("$q_3$", "rad", "$q_1$", "rad")
    assert [curve.label for curve in third.curves] == ["run a", "run b"]
    np.testing.assert_allclose(third.curves[0].values, 3.0 * TIME)
    np.testing.assert_allclose(third.curves[1].values, -6.0 * TIME)
    np.testing.assert_allclose(first.curves[1].values, -2.0 * TIME)
    np.testing.assert_allclose(third.reference[0].values, 30.0 * TIME)  # the first run's
    assert axes_of(outcome(Panel("torque", (1,), ("a",))))[0].reference == ()


def test_predictions_stand_where_their_component_is_drawn() -> None:
    panel = Panel("joint_position", (0, 1, 2), ("a",), predictions=("both",), levels=(Level(0.5, "wall"),))
    first, second, third = axes_of(outcome(panel))
    assert {axis.levels for axis in (first, second, third)} == {(("wall", 0.5),)}
    assert first.predictions == (("rest, predicted", 8.0),)
    assert second.predictions == ()
    assert third.predictions == (("rest, predicted", 7.0),)


def test_curves_end_with_the_time_axis() -> None:
    (axis,) = axes_of(outcome(Panel("joint_position", (0,), ("a",)), until=0.2))
    np.testing.assert_allclose(axis.curves[0].time, [0.0, 0.1, 0.2])


def test_table_leaves_cells_empty_where_a_curve_has_no_value() -> None:
    panels = (Panel("joint_position", (1,), ("a", "b")), Panel("torque", (0,), ("a",)))
    assert table(outcome(*panels, steps=2)).splitlines() == [
        "time [s],joint_position_2 [m] run a,joint_position_2 [m] run b,torque_1 [N·m] run a",
        "0,0,-0,0",
        "0.1,0.2,-0.4,1",
        "0.2,0.4,-0.8,2",
        "0.3,0.6,,3",
        "0.4,0.8,,",
    ]


@pytest.mark.parametrize("count", [1, 4])
def test_figure_has_one_size_whatever_it_shows(count: int) -> None:
    panels = [Panel("joint_position", (0,), ("a", "b"), limits=(-1.0, 1.0))] * count
    with Image.open(io.BytesIO(figure_content(draw(outcome(*panels)), ".png"))) as frame:
        assert frame.size == (1000, 700)


def test_as_many_runs_as_there_are_colours_are_told_apart() -> None:
    names = tuple("abcdefgh"[: len(COLORS)])
    item = outcome(Panel("joint_position", (0,), names))
    runs = {name: recorded(name, index - 1.5) for index, name in enumerate(names)}
    full = replace(item, recorded=runs)
    with Image.open(io.BytesIO(figure_content(draw(full), ".png"))) as frame:
        pixels = np.asarray(frame.convert("RGB"), dtype=np.int64)
    for color in COLORS:
        assert (np.abs(pixels - rgb(color)) < 20).all(axis=-1).sum() > 300
    assert len(table(full).splitlines()[0].split(",")) == 1 + len(COLORS)


def test_runs_keep_their_colour_in_every_axes() -> None:
    panels = (Panel("joint_position", (0,), ("a",)), Panel("joint_position", (0,), ("b",)))
    with Image.open(io.BytesIO(figure_content(draw(outcome(*panels)), ".png"))) as frame:
        pixels = np.asarray(frame.convert("RGB"), dtype=np.int64)
    first, second = (
        (np.abs(pixels - color) < 20).all(axis=-1)[:640]  # without the legend
        for color in (rgb(COLORS[0]), rgb(COLORS[1]))
    )
    assert first[:310].sum() > 500
    assert first[340:].sum() == 0
    assert second[340:].sum() > 500
    assert second[:310].sum() == 0


def test_runs_differ_in_more_than_their_colour() -> None:
    names = tuple("abcdefgh"[: len(COLORS)])
    item = replace(
        outcome(Panel("joint_position", (0,), names)), recorded={name: recorded(name, 1.0) for name in names}
    )
    (axes,) = draw(item).axes
    cues = [(line.get_marker(), line.get_linewidth()) for line in axes.get_lines()]
    assert len(set(cues)) == len(COLORS)
