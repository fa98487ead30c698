"""Plots of a comparison: performance profiles, scores by task, compute time against score."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from prp_gym.comparison.statistics import (
    BEST_AGENT,
    BEST_CONTROLLER,
    BEST_FLOOR,
    Aggregate,
    best_of,
    estimate_score,
    score_of,
)
from prp_gym.comparison.values import AGENT, CONTROLLER, FLOOR, KINDS, Condition
from prp_gym.figures.figure_file import new_figure
from prp_gym.palette import BLUE, GRAY, LIGHT_GRAY, SERIES, SKY_BLUE, VERMILLION, Style
from prp_gym.tables.matrix import short_id

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from prp_gym.figures.notebook_figure import NotebookFigure

COLORS = {CONTROLLER: BLUE, AGENT: VERMILLION, FLOOR: GRAY}
"""Colours of the kinds of policies."""

TUNING = SKY_BLUE
"""Colour of the searches for the gains of controllers."""

GRID = LIGHT_GRAY
_MODES = tuple(style for style in SERIES if style.color not in COLORS.values())

_MARKERS = {CONTROLLER: "o", AGENT: "D", FLOOR: "x"}
_BESIDE: dict[str, Any] = {"textcoords": "offset points", "va": "center", "fontsize": 6}
_MICROSECONDS = 1e6


def mode_style(index: int) -> Style:
    """Style of an action mode by its position: repeated colours have another line style."""
    round_, position = divmod(index, len(_MODES))
    return _MODES[position]._replace(line=_MODES[(position + round_) % len(_MODES)].line)


def draw_profiles(aggregates: Sequence[Aggregate]) -> "NotebookFigure":
    """Share of scores above each threshold, one panel for each scenario, with pointwise 95 % bands."""
    scenarios = list(dict.fromkeys(item.scenario for item in aggregates))
    shown = [item for item in aggregates if item.family != BEST_AGENT]
    families = list(dict.fromkeys(item.family for item in shown))
    modes = [name for name in families if name not in (BEST_CONTROLLER, BEST_FLOOR)]
    styles = {BEST_CONTROLLER: (COLORS[CONTROLLER], "-"), BEST_FLOOR: (COLORS[FLOOR], "--")}
    styles |= {name: mode_style(index)[:2] for index, name in enumerate(modes)}
    count = max(1, len(scenarios))  # without a family of policies the only panel stays empty
    figure = new_figure(6.0 * count, 5.5)
    for axes, scenario in zip(figure.subplots(1, count, squeeze=False)[0], scenarios, strict=False):
        for item in (item for item in shown if item.scenario == scenario):
            profile, (color, style) = item.profile, styles[item.family]
            label = f"{item.family} ({item.tasks} tasks)" if item.tasks > 1 else f"{item.family} (1 task)"
            axes.plot(profile.thresholds, profile.value, style, color=color, linewidth=1.8, label=label)
            axes.fill_between(
                profile.thresholds, profile.low, profile.high, color=color, alpha=0.15, linewidth=0
            )
        axes.set(title=f"scenario {scenario}", xlabel="score τ", ylabel="share of episodes with score > τ")
        axes.set(xlim=(0.0, 1.0), ylim=(0.0, 1.02))
        axes.grid(True, color=GRID, linewidth=0.6)
        axes.legend(loc="lower left", fontsize=8, frameon=False)
    return figure


def draw_scores(conditions: Sequence[Condition], seed: int) -> "NotebookFigure":
    """Scores by task: the best of each kind with its 95 % interval, all others as small points.

    Args:
        conditions: environments and scenarios with their policies.
        seed: random seed of the bootstrap.
    """
    scenarios = list(dict.fromkeys(condition.scenario for condition in conditions))
    ids = list(dict.fromkeys(condition.environment_id for condition in conditions))
    figure = new_figure(1.5 + 5.0 * len(scenarios), 1.8 + 0.62 * len(ids))
    rows = figure.subplots(1, len(scenarios), squeeze=False, sharey=True)[0]
    for axes, scenario in zip(rows, scenarios, strict=True):
        for condition in (condition for condition in conditions if condition.scenario == scenario):
            _draw_condition(axes, condition, float(ids.index(condition.environment_id)), seed)
        axes.set_yticks(range(len(ids)), [short_id(name) for name in ids])
        axes.set(title=f"scenario {scenario}", xlabel="score", xlim=(0.0, 1.02), ylim=(len(ids) - 0.5, -0.5))
        axes.grid(True, axis="x", color=GRID, linewidth=0.6)
        for line in range(1, len(ids)):
            axes.axhline(line - 0.5, color=GRID, linewidth=0.6)
    _legend(figure, _kinds(conditions))
    return figure


def _draw_condition(axes: "Axes", condition: Condition, row: float, seed: int) -> None:
    """One row with a line for each kind: its best policy with the interval, and the others."""
    kinds = [kind for kind in COLORS if condition.of_kind(kind)]
    for kind, offset in zip(kinds, _offsets(len(kinds)), strict=True):
        entries = condition.of_kind(kind)
        score, height = estimate_score(best_of(entries), seed), row + offset
        others = [score_of(entry) for entry in entries]
        axes.plot(others, [height] * len(others), "|", color=COLORS[kind], markersize=6, alpha=0.6)
        axes.plot([score.low, score.high], [height, height], color=COLORS[kind], linewidth=2.2)
        axes.plot([score.value], [height], _MARKERS[kind], color=COLORS[kind], markersize=6)
        axes.annotate(f"{score.value:.2f}", (0.0, height), xytext=(3, 0), **_BESIDE)


def _kinds(conditions: Sequence[Condition]) -> list[str]:
    """The kinds of policies that there are, in the order of their colours."""
    return [kind for kind in COLORS if any(condition.of_kind(kind) for condition in conditions)]


def _offsets(count: int) -> list[float]:
    return [0.2 * (index - (count - 1) / 2.0) for index in range(count)]


def _legend(figure: "Figure", kinds: Sequence[str]) -> None:
    from matplotlib.lines import Line2D

    handles = [
        Line2D([], [], color=COLORS[kind], marker=_MARKERS[kind], linestyle="", label=KINDS[kind])
        for kind in kinds
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=len(kinds), frameon=False)


def draw_compute(conditions: Sequence[Condition]) -> "NotebookFigure":
    """Score against compute time, one point for each policy and task, one panel for each scenario."""
    scenarios = list(dict.fromkeys(condition.scenario for condition in conditions))
    figure = new_figure(6.0 * len(scenarios), 5.0)
    panels = figure.subplots(1, len(scenarios), squeeze=False, sharey=True)[0]
    kinds = _kinds(conditions)
    for axes, scenario in zip(panels, scenarios, strict=True):
        for kind in kinds:
            shown = (condition for condition in conditions if condition.scenario == scenario)
            entries = [entry for condition in shown for entry in condition.of_kind(kind)]
            times = [_MICROSECONDS * entry.compute_time for entry in entries]
            scores = [score_of(entry) for entry in entries]
            axes.plot(times, scores, _MARKERS[kind], color=COLORS[kind], markersize=5, alpha=0.65)
        label_decades(axes)
        axes.set(title=f"scenario {scenario}", xlabel="compute time per action [µs]", ylim=(0.0, 1.02))
        axes.grid(True, which="both", color=GRID, linewidth=0.5)
    panels[0].set_ylabel("score (one point per policy and task)")
    _legend(figure, kinds)
    return figure


def label_decades(axes: "Axes") -> None:
    """Make the axis of x logarithmic, labelled at 1, 2 and 5 times the powers of ten.

    Args:
        axes: axes of matplotlib.
    """
    from matplotlib.ticker import FormatStrFormatter, LogLocator, NullFormatter

    axes.set_xscale("log")
    axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.xaxis.set_major_formatter(FormatStrFormatter("%g"))
    axes.xaxis.set_minor_formatter(NullFormatter())
