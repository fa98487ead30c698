"""Figures of the recorded runs, and their data as CSV."""

import csv
import io
import itertools
import re
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from prp_gym.figures.figure_file import new_figure
from prp_gym.palette import (
    BLACK,
    BLUE,
    BLUISH_GREEN,
    GRAY,
    LIGHT_GRAY,
    ORANGE,
    REDDISH_PURPLE,
    VERMILLION,
)
from prp_gym.reproduction.experiment import Panel
from prp_gym.reproduction.outcome import FigureOutcome
from prp_gym.reproduction.signals import find_signal, series
from prp_gym.robot.arrays import Array

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes

    from prp_gym.figures.notebook_figure import NotebookFigure

_SIZE = (10.0, 7.0)  # inches
COLORS = (BLUE, VERMILLION, BLUISH_GREEN, REDDISH_PURPLE)
"""Colours of the runs of a figure in their order; a figure cannot have more runs."""

REFERENCE_LABEL = "reference"
"""Label of the reference in legends and data; no run may have the same."""

_MARKERS = ("", "s", "^", "D")  # of the runs in their order; the first one is also the thickest
_MARKERS_OF_A_CURVE = 7  # markers of a curve
_REFERENCE = BLACK
_PREDICTED = ORANGE
_LEVEL = GRAY
_PREDICTED_STYLES = ("-", "--", ":")


class Curve(NamedTuple):
    """One line of a figure.

    Attributes:
        run: name of the run.
        label: label in the legend and in the column header of the CSV file.
        time: times of the values (n) [s].
        values: values over time (n), in the unit of the axes.
    """

    run: str
    label: str
    time: Array
    values: Array


class Axis(NamedTuple):
    """One axes of a figure, as data.

    Attributes:
        symbol: symbol of the drawn quantity (mathematical text).
        unit: unit of the drawn quantity.
        column: name of the quantity without mathematical text, for column headers.
        curves: curves of the runs, one for each.
        reference: curves drawn dashed, at most one.
        levels: labels and values of the horizontal lines.
        predictions: labels and values of the lines at predicted values.
        limits: limits of the vertical axis; empty to fit the curves.
    """

    symbol: str
    unit: str
    column: str
    curves: tuple[Curve, ...]
    reference: tuple[Curve, ...]
    levels: tuple[tuple[str, float], ...]
    predictions: tuple[tuple[str, float], ...]
    limits: tuple[float, ...]


def axes_of(outcome: FigureOutcome) -> list[Axis]:
    """The axes of a figure, from top to bottom."""
    return [axis for panel in outcome.experiment.panels for axis in _panel_axes(outcome, panel)]


def _panel_axes(outcome: FigureOutcome, panel: Panel) -> Iterator[Axis]:
    until = outcome.experiment.until
    signal = find_signal(panel.signal)
    for component in panel.components:
        curves = [_curve(outcome, name, panel.signal, component, until) for name in panel.runs]
        reference = []
        if panel.reference:
            reference.append(_curve(outcome, panel.runs[0], panel.reference, component, until))
            reference[0] = reference[0]._replace(label=REFERENCE_LABEL)
        column = f"{panel.signal}_{component + 1}"
        yield Axis(
            signal.symbols[component],
            signal.units[component],
            column,
            tuple(curves),
            tuple(reference),
            tuple((level.label, level.value) for level in panel.levels),
            tuple(_predicted(outcome, panel, component)),
            panel.limits,
        )


def _curve(outcome: FigureOutcome, run: str, signal: str, component: int, until: float) -> Curve:
    recorded = outcome.recorded[run]
    time, values = series(recorded.rollout, signal, [component])
    shown = time <= until + recorded.rollout.period / 2
    return Curve(run, recorded.run.label, time[shown], values[shown, 0])


def _predicted(outcome: FigureOutcome, panel: Panel, component: int) -> list[tuple[str, float]]:
    """Labels and values of the predictions of the panel's checks for a component."""
    found = []
    for verdict in outcome.verdicts:
        if verdict.check.name in panel.predictions:
            all_of_them = range(len(verdict.predicted))
            components = list(verdict.check.measure.arguments.get("components", all_of_them))
            if component in components:
                found.append((verdict.check.label, float(verdict.predicted[components.index(component)])))
    return found


def draw(outcome: FigureOutcome) -> "NotebookFigure":
    """The figure, of 1000 x 700 pixels as PNG; runs differ in colour and marker."""
    items = axes_of(outcome)
    figure = new_figure(*_SIZE)
    experiment = outcome.experiment
    figure.suptitle(_with_subscripts(f"Figure {experiment.number}: {experiment.title}"), fontsize=13)
    rows = figure.subplots(len(items), 1, sharex=True, squeeze=False)[:, 0]
    names = dict.fromkeys(curve.run for item in items for curve in item.curves)
    colors = dict(zip(names, COLORS, strict=False))
    lines: dict[str, Artist] = {}
    for axes, item in zip(rows, items, strict=True):
        lines |= _draw_axis(axes, item, colors)
    rows[0].set_xlim(0.0, experiment.until)
    rows[-1].set_xlabel("time [s]")
    figure.align_ylabels(list(rows))
    labels = sorted(lines, key=lambda label: label == REFERENCE_LABEL)  # the reference last
    handles = [lines[label] for label in labels]
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), frameon=False)
    return figure


def _draw_axis(axes: "Axes", item: Axis, colors: Mapping[str, str]) -> dict[str, "Artist"]:
    """Draw one axes; its curves by label."""
    levels = _draw_levels(axes, item)
    lines: dict[str, Artist] = {}
    for index, curve in enumerate(item.curves):  # thin over thick: equal curves are both seen
        width = 2.6 if index == 0 else 1.2
        color = colors[curve.run]
        (line,) = axes.plot(curve.time, curve.values, color=color, linewidth=width, markersize=4)
        line.set_marker(_MARKERS[COLORS.index(color)])
        line.set_markevery((COLORS.index(color) * 3, max(1, len(curve.time) // _MARKERS_OF_A_CURVE)))
        lines[_with_subscripts(curve.label)] = line
    for curve in item.reference:
        (line,) = axes.plot(curve.time, curve.values, color=_REFERENCE, linewidth=1.1, linestyle="--")
        lines[curve.label] = line
    axes.set_ylabel(f"{item.symbol} [{item.unit}]")
    axes.grid(True, color=LIGHT_GRAY, linewidth=0.6)
    axes.margins(y=0.08)
    if item.limits:
        axes.set_ylim(*item.limits)
    if levels:
        axes.legend(handles=levels, loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize=9, frameon=False)
    return lines


def _draw_levels(axes: "Axes", item: Axis) -> list["Artist"]:
    """Draw the horizontal lines of one axes; predictions differ in their dashes."""
    rows = [(label, value, _LEVEL, "-") for label, value in item.levels]
    styles = itertools.cycle(_PREDICTED_STYLES)
    rows += [
        (label, value, _PREDICTED, style)
        for (label, value), style in zip(item.predictions, styles, strict=False)
    ]
    drawn: list[Artist] = []
    for label, value, color, style in rows:
        text = f"{_with_subscripts(label)}\n{value:.4g} {item.unit}"
        drawn.append(axes.axhline(value, color=color, linestyle=style, linewidth=1.0, label=text))
    return drawn


def _with_subscripts(text: str) -> str:
    """Symbols such as K_P and q_d as mathematical text."""
    return re.sub(r"\b([A-Za-z])_(\w+)", r"$\1_{\2}$", text)


def table(outcome: FigureOutcome) -> str:
    """The data of a figure as CSV: a column of time [s] and one for each curve, empty without a value."""
    columns: dict[str, Curve] = {}
    for item in axes_of(outcome):
        for curve in (*item.curves, *item.reference):
            columns[f"{item.column} [{item.unit}] {curve.label}"] = curve
    time = max((curve.time for curve in columns.values()), key=len)
    target = io.StringIO()
    writer = csv.writer(target, lineterminator="\n")
    writer.writerow(["time [s]", *columns])
    padded = [_padded(curve.values, len(time)) for curve in columns.values()]
    for moment, *row in zip(time.tolist(), *padded, strict=True):
        writer.writerow([f"{moment:.6g}", *("" if np.isnan(value) else f"{value:.9g}" for value in row)])
    return target.getvalue()


def _padded(values: Array, length: int) -> list[float]:
    padded: list[float] = np.concatenate([values, np.full(length - len(values), np.nan)]).tolist()
    return padded
