"""`draw_episode`: one episode as a figure."""

from typing import TYPE_CHECKING, Any

import numpy as np

from prp_gym.evaluation.metrics.force import in_contact
from prp_gym.evaluation.rollout import Rollout
from prp_gym.figures.curve import EpisodeCurve, EpisodePanel
from prp_gym.figures.episode_panels import ACTUAL, MODEL, REFERENCE, episode_panels
from prp_gym.figures.figure_file import new_figure
from prp_gym.palette import BLACK, BLUE, BLUISH_GREEN, LIGHT_GRAY, VERMILLION

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from prp_gym.figures.notebook_figure import NotebookFigure

_COLUMNS = 2
_WIDTH, _PANEL_HEIGHT, _TITLE_HEIGHT = 10.0, 2.2, 0.8  # [inches]
_COLORS, _MARKERS = (BLUE, VERMILLION, BLUISH_GREEN), ("o", "s", "^")
_STYLES: dict[str, Any] = {ACTUAL: "-", REFERENCE: "--", MODEL: ":"}
_WIDTHS = {ACTUAL: 1.4, REFERENCE: 1.1, MODEL: 1.4}
_NAMES = {ACTUAL: "actual", REFERENCE: "reference", MODEL: "target model"}
_ROW_OF_NAMES: dict[str, Any] = {  # above the axes, where it hides no curve
    "fontsize": 8,
    "ncols": 6,
    "frameon": False,
    "borderpad": 0.2,
    "handlelength": 1.8,
    "columnspacing": 1.2,
}
_MARKERS_OF_A_CURVE = 8  # markers of a line
_CONTACT = "#E4E4E4"
_LIMIT_SHOWN_FROM = 0.5  # of a limit; a smaller torque would become a flat line beside it


def draw_episode(rollout: Rollout, policy: str = "") -> "NotebookFigure":
    """One episode: motion with its reference, errors, torques with their limits, contact force, reward.

    Components differ in colour and marker, the motion and its references in line style. The background of
    the time in which the tip touches the surface is grey.

    Args:
        rollout: the episode.
        policy: name of the policy for the title; empty to leave it out.

    Returns:
        a figure of matplotlib with the panels that the task has; `savefig` writes it as PNG, SVG or PDF.
    """
    panels = episode_panels(rollout)
    rows = -(-len(panels) // _COLUMNS)
    figure = new_figure(_WIDTH, _PANEL_HEIGHT * rows + _TITLE_HEIGHT)
    grid = figure.subplots(rows, _COLUMNS, squeeze=False, sharex=True)
    for axes, panel in zip(grid.ravel(), panels, strict=False):
        _draw(axes, panel, rollout)
    _label_time(grid, len(panels))
    _legend(figure, panels, rollout)
    figure.suptitle(_title(rollout, policy), fontsize=11)
    return figure


def _label_time(grid: Any, count: int) -> None:
    """Label the time below the last panel of each column, and hide axes without a panel."""
    for axes in grid.ravel()[count:]:
        axes.set_axis_off()
    last = {index % _COLUMNS: axes for index, axes in enumerate(grid.ravel()[:count])}
    for axes in last.values():
        axes.set_xlabel("time [s]")
        axes.tick_params(labelbottom=True)


def _title(rollout: Rollout, policy: str) -> str:
    parts = [rollout.environment_id, f"scenario {rollout.scenario}", f"seed {rollout.seed}"]
    ended = ", diverged" if rollout.diverged else ""
    score = f"mean reward {rollout.reward.sum() / rollout.planned_periods:.3f}{ended}"
    return f"{', '.join([*parts, *([policy] if policy else [])])}: {score}"


def _draw(axes: "Axes", panel: EpisodePanel, rollout: Rollout) -> None:
    """One panel with its legend."""
    for start, end in contact_spans(rollout):
        axes.axvspan(start, end, color=_CONTACT, linewidth=0, zorder=0)
    for curve in panel.curves:
        _draw_curve(axes, curve, rollout)
    _draw_limits(axes, panel)
    if panel.fixed_range:
        axes.set_ylim(panel.fixed_range)
    axes.set_ylabel(panel.quantity)
    axes.set_xlim(0.0, rollout.duration)
    axes.grid(True, color=LIGHT_GRAY, linewidth=0.5)
    names = [line for line in axes.get_lines() if not str(line.get_label()).startswith("_")]
    axes.legend(handles=names, loc="lower left", bbox_to_anchor=(0.0, 0.97), **_ROW_OF_NAMES)


def _draw_curve(axes: "Axes", curve: EpisodeCurve, rollout: Rollout) -> None:
    step = max(1, len(curve.values) // _MARKERS_OF_A_CURVE)
    axes.plot(
        rollout.time[: len(curve.values)],
        curve.values,
        _STYLES[curve.role],
        color=_COLORS[curve.component],
        linewidth=_WIDTHS[curve.role],
        marker=_MARKERS[curve.component] if curve.role == ACTUAL else "",
        markersize=4,
        markevery=(curve.component * step // len(_COLORS), step),
        label=curve.label if curve.role == ACTUAL else "_",  # the figure's legend explains the references
    )


def _draw_limits(axes: "Axes", panel: EpisodePanel) -> None:
    """The limits that the curves come near; all of them are named in the legend."""
    highest = max((float(np.abs(curve.values).max(initial=0.0)) for curve in panel.curves), default=0.0)
    for curve, (label, limit) in zip(panel.curves, panel.limits, strict=False):
        color = _COLORS[curve.component]
        if highest < _LIMIT_SHOWN_FROM * limit:
            axes.plot([], [], "-.", color=color, linewidth=1.0, label=f"{label}: ±{limit:g}")
            continue
        for value in (-limit, limit):
            shown = f"{label}: ±{limit:g}" if value > 0.0 else "_"
            axes.axhline(value, linestyle="-.", color=color, linewidth=1.0, label=shown)


def contact_spans(rollout: Rollout) -> list[tuple[float, float]]:
    """Start and end of every time in which the tip touches the surface [s]; none without a surface.

    Args:
        rollout: the episode.
    """
    if "contact_force" not in rollout.fields:
        return []
    touches = in_contact(rollout.fields["contact_force"]).astype(np.int8)
    changes = np.diff(np.concatenate([[0], touches, [0]]))
    starts, ends = np.flatnonzero(changes == 1), np.flatnonzero(changes == -1) - 1
    time = rollout.time
    return [(float(time[start]), float(time[end])) for start, end in zip(starts, ends, strict=True)]


def _legend(figure: "NotebookFigure", panels: list[EpisodePanel], rollout: Rollout) -> None:
    """What line styles and background mean."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    roles = {curve.role for panel in panels for curve in panel.curves}
    handles: list[Line2D | Patch] = [
        Line2D([], [], color=BLACK, linestyle=_STYLES[role], label=_NAMES[role])
        for role in _STYLES
        if role in roles
    ]
    if any(panel.limits for panel in panels):
        handles.append(Line2D([], [], color=BLACK, linestyle="-.", label="actuator limit"))
    if contact_spans(rollout):
        handles.append(Patch(color=_CONTACT, label="tip in contact"))
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles), frameon=False)
