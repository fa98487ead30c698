"""`Charts`: the live plots of a page."""

from typing import Any

import numpy as np

from prp_gym.palette import BLACK, BLUE, BLUISH_GREEN, GRAY, ORANGE, REDDISH_PURPLE, VERMILLION
from prp_gym.viewing.plot import Line, Plot

_COLOURS = (BLUE, VERMILLION, BLUISH_GREEN, REDDISH_PURPLE)
_DESIRED, _LIMIT, _PREDICTED = BLACK, GRAY, ORANGE
_DASHES = {"desired": [8, 5], "predicted": [2, 3]}
_OF_COMPONENT: tuple[list[int], ...] = (
    [],
    [12, 4],
    [12, 3, 2, 3],
    [5, 4],
)  # measured ones; the first is solid
_POINTS = 400  # of a line at most
_HEIGHT = 220  # pixels


class Charts:
    """The plots of a session in one container of the page.

    Args:
        gui: viser's controls.
        container: tab to which the charts are added.
    """

    def __init__(self, gui: Any, container: Any) -> None:
        self._gui, self._container = gui, container
        self._handles: list[Any] = []
        self._shown: list[tuple[object, ...]] = []

    def show(self, plots: tuple[Plot, ...]) -> None:
        """Show the plots; the charts are made anew where other lines are to be shown."""
        shown: list[tuple[object, ...]] = [
            (plot.title, *((line.name, _is_complete(line)) for line in plot.lines)) for plot in plots
        ]
        if [item[0] for item in shown] != [item[0] for item in self._shown]:
            self._clear()
        for index, plot in enumerate(plots):
            if index < len(self._handles) and shown[index] == self._shown[index]:
                self._handles[index].data = _data(plot)
            else:
                with self._container:
                    self._replace(index, plot)
        self._shown = shown

    def _clear(self) -> None:
        for handle in self._handles:
            handle.remove()
        self._handles = []

    def _replace(self, index: int, plot: Plot) -> None:
        """Add a chart in the position of an existing one, or as the last."""
        made = self._gui.add_uplot(
            data=_data(plot),
            series=({"label": "time since the start of the episode [s]"}, *_series(plot)),
            title=f"{plot.title} [{plot.unit}], time [s]",
            scales={"x": {"time": False}},
            axes=({"size": 36}, {"size": 56}),
            legend={"show": True, "live": False},
            height=_HEIGHT,
            order=float(index),
        )
        if index < len(self._handles):
            self._handles[index].remove()
            self._handles[index] = made
        else:
            self._handles.append(made)


def _data(plot: Plot) -> tuple[Any, ...]:
    """The times and the values of the lines, thinned to what a chart can show."""
    stride = max(1, len(plot.time) // _POINTS)
    rows = [plot.time, *(line.values for line in plot.lines)]
    return tuple(np.ascontiguousarray(row[::stride], dtype=np.float64) for row in rows)


def _series(plot: Plot) -> list[dict[str, Any]]:
    """Colour and dashes of the lines; a predicted component is dotted in the colour of the measured one."""
    measured = [line.name for line in plot.lines if line.kind == "measured"]
    return [
        {
            "label": line.name,
            "stroke": _colour(line, measured),
            "width": 1.5 if line.kind in ("measured", "predicted") else 1.0,
            "dash": _dashes(line, measured),
            "points": {"show": False},
            "auto": _is_complete(line),  # a range over values of which some are missing would be empty
        }
        for line in plot.lines
    ]


def _is_complete(line: Line) -> bool:
    """Whether a line has a value at every time."""
    return not np.isnan(line.values).any()


def _dashes(line: Line, measured: list[str]) -> list[int]:
    """Lengths of dashes and gaps [pixels]; none for a solid line."""
    if line.kind == "measured":
        return _OF_COMPONENT[measured.index(line.name) % len(_OF_COMPONENT)]
    return _DASHES.get(line.kind, [])


def _colour(line: Line, measured: list[str]) -> str:
    if line.kind == "measured":
        return _COLOURS[measured.index(line.name) % len(_COLOURS)]
    if line.kind == "predicted":
        own = [name for name in measured if line.name.startswith(f"{name}, ")]
        return _COLOURS[measured.index(own[0]) % len(_COLOURS)] if own else _PREDICTED
    return _DESIRED if line.kind == "desired" else _LIMIT
