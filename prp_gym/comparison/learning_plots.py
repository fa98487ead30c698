"""Learning curves: score against simulated time, beside the scores of the best controller and floor."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from prp_gym.comparison.plots import COLORS, GRID, TUNING, label_decades, mode_style
from prp_gym.comparison.statistics import best_of, score_of
from prp_gym.comparison.values import AGENT, CONTROLLER, FLOOR, Condition, Entry, History
from prp_gym.figures.figure_file import new_figure
from prp_gym.palette import Style
from prp_gym.robot.arrays import Array
from prp_gym.tables.matrix import short_id

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes

    from prp_gym.figures.notebook_figure import NotebookFigure

_COLUMNS = 3
_DASHES = ("-", "--", ":")
_LEVELS = {CONTROLLER: "-.", FLOOR: ":"}  # line styles


def common_curve(histories: Sequence[History]) -> tuple[Array, Array]:
    """Scores of several training seeds at common times, interpolated linearly.

    Args:
        histories: one for each training seed.

    Returns:
        simulated time (n) [s] within the span that all of them cover, and scores (training seeds, n).
    """
    times = [history.simulated_seconds for history in histories]
    first, last = max(own[0] for own in times), min(own[-1] for own in times)
    grid = np.unique(np.concatenate(times))
    grid = grid[(grid >= first) & (grid <= last)]
    scores = [np.interp(grid, own, history.score) for own, history in zip(times, histories, strict=True)]
    return grid, np.stack(scores)


def draw_learning(conditions: Sequence[Condition]) -> "NotebookFigure":
    """Score against simulated time, one panel for each environment and scenario of training.

    A line is the median over training seeds and its band their range. A tuned controller is a staircase; the
    best controller and the best floor are horizontal lines. Scores are those of the held-out episodes of
    training, or of the episodes of tuning.
    """
    panels = _panels(conditions)
    columns = min(_COLUMNS, len(panels))
    rows = -(-len(panels) // _COLUMNS)
    figure = new_figure(max(5.2 * columns, 8.0), 4.0 * rows + 0.8)
    grid = figure.subplots(rows, columns, squeeze=False).ravel()
    levels = {
        (condition.environment_id, condition.scenario): {
            kind: score_of(best_of(condition.of_kind(kind))) for kind in _LEVELS if condition.of_kind(kind)
        }
        for condition in conditions
    }
    agents = [entry.policy for own in panels.values() for entry in own if entry.kind == AGENT]
    names = enumerate(dict.fromkeys(agents))
    styles = {name: mode_style(index) for index, name in names}
    lines: dict[str, Artist] = {}
    for axes in grid[len(panels) :]:
        axes.set_axis_off()
    for axes, (key, entries) in zip(grid, panels.items(), strict=False):
        lines |= _draw_panel(axes, entries, styles, levels.get(key, {}))
        axes.set(title=f"{short_id(key[0])}, {key[1]}", xlabel="simulated time [s]", ylabel="score")
    figure.legend(lines.values(), lines.keys(), loc="outside lower center", ncols=3, frameon=False)
    return figure


def _panels(conditions: Sequence[Condition]) -> Mapping[tuple[str, str], list[Entry]]:
    """Trained and tuned policies, each of them once, by environment and scenario of training."""
    seen: dict[tuple[str, str, str], Entry] = {}
    for condition in conditions:
        for entry in condition.of_kind(AGENT, CONTROLLER):
            if entry.histories:
                seen[condition.environment_id, entry.histories[0].scenario, entry.policy] = entry
    panels: dict[tuple[str, str], list[Entry]] = {}
    for (environment_id, scenario, _), entry in seen.items():
        panels.setdefault((environment_id, scenario), []).append(entry)
    return panels


def _draw_panel(
    axes: "Axes", entries: Sequence[Entry], styles: Mapping[str, Style], levels: Mapping[str, float]
) -> dict[str, "Artist"]:
    """Draw one panel; returns its lines by label."""
    lines: dict[str, Artist] = {}
    for entry in (entry for entry in entries if entry.kind == AGENT):
        time, scores = common_curve(entry.histories)
        color, style, _ = styles[entry.policy]
        median = np.median(scores, axis=0)
        (lines[entry.policy],) = axes.plot(time, median, style, color=color, linewidth=1.8)
        axes.fill_between(time, scores.min(axis=0), scores.max(axis=0), color=color, alpha=0.18, linewidth=0)
    for index, entry in enumerate(entry for entry in entries if entry.kind == CONTROLLER):
        history, style = entry.histories[0], _DASHES[index % len(_DASHES)]
        time, label = history.simulated_seconds, "controllers, best candidate of the search"
        (line,) = axes.step(time, history.score, style, where="post", color=TUNING)
        lines.setdefault(label, line)
    for kind, level in levels.items():
        lines[f"best {kind}"] = axes.axhline(
            level, color=COLORS[kind], linestyle=_LEVELS[kind], linewidth=1.3
        )
        axes.annotate(f"{level:.3f}", (0.01, level), xycoords=("axes fraction", "data"), va="top", fontsize=8)
    label_decades(axes)
    axes.set_ylim(0.0, 1.02)
    axes.grid(True, color=GRID, linewidth=0.6)
    return lines
