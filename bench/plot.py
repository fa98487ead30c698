"""Figure of the benchmark: throughput against the number of environments."""

import io
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from bench.names import is_as_shipped
from bench.rounds import CONTACT, FREE, REACHER

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Row = Mapping[str, Any]

_SIZE = (10.0, 5.0)  # inches
_DPI = 110
_THREADS = 0
_CURVES = (
    ("native", FREE, "prp_gym, native, free space", "#0b5fa5", "o"),
    ("native", CONTACT, "prp_gym, native, contact task", "#5a9e3d", "s"),
    ("sync", FREE, "prp_gym in SyncVectorEnv", "#d1661f", "^"),
    ("async", FREE, "prp_gym in AsyncVectorEnv", "#8d5bb8", "D"),
    ("sync", REACHER, "Reacher-v5 in SyncVectorEnv", "#777777", "v"),
)
_BARE = (
    (True, "--", "bare mj_step on all cores, as shipped"),
    (False, ":", "bare mj_step on all cores, no clock"),
)


def draw(rows: Sequence[Row]) -> bytes:
    """Throughput against N at both control frequencies, as a PNG."""
    figure = Figure(figsize=_SIZE, dpi=_DPI, layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(1, 2, sharey=True)
    for axes, frequency in zip(panels, (500.0, 50.0), strict=True):
        _draw_panel(axes, rows, frequency)
    panels[0].set_ylabel("environment steps per second")
    handles: dict[str, Any] = {}
    for axes in panels:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            handles.setdefault(label, handle)
    figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=3, frameon=False)
    target = io.BytesIO()
    figure.savefig(target, format="png", dpi=_DPI)
    return target.getvalue()


def _draw_panel(axes: "Axes", rows: Sequence[Row], frequency: float) -> None:
    here = [row for row in rows if row["control_frequency"] == frequency or row["environment"] == REACHER]
    for kind, environment, label, color, marker in _CURVES:
        points = sorted(
            (row["num_envs"], row["median"])
            for row in here
            if (row["kind"], row["environment"]) == (kind, environment)
            and is_as_shipped(row)
            and (kind != "native" or row["threads"] == _THREADS)
        )
        if points:
            counts, rates = zip(*points, strict=True)
            axes.plot(counts, rates, color=color, marker=marker, markersize=6, linewidth=1.8, label=label)
    for clock, style, label in _BARE:
        for row in here:
            if (row["kind"], row["environment"], row["clock"]) == ("bare_all_cores", FREE, clock):
                axes.axhline(row["median"], color="#222222", linestyle=style, linewidth=1.2, label=label)
    _label(axes, f"control at {frequency:g} Hz ({1000 / frequency:g} substeps)")


def _label(axes: "Axes", title: str) -> None:
    axes.set_title(title, fontsize=11)
    axes.set_xscale("log", base=2)
    axes.set_yscale("log")
    axes.set_xticks([1, 8, 64, 256, 1024, 4096], ["1", "8", "64", "256", "1024", "4096"])
    axes.xaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:,.0f}"))
    axes.set_xlabel("environments N")
    axes.grid(True, which="major", color="#d5d5d5", linewidth=0.7)
