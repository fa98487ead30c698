"""`Plot` and `Line`: what a live plot shows, without any graphics."""

from dataclasses import dataclass

from prp_gym.robot.arrays import Array


@dataclass(frozen=True, eq=False)
class Line:
    """One line of a plot.

    Attributes:
        name: name in the legend; that of a predicted line says so, and by which formula.
        values: values at the times of the plot (T) in its unit; NaN where there is none.
        kind: `measured`, `desired`, `predicted` or `limit`.
    """

    name: str
    values: Array
    kind: str = "measured"


@dataclass(frozen=True, eq=False)
class Plot:
    """A plot over time.

    Attributes:
        title: quantity that the plot shows.
        unit: unit of the values.
        time: time since the start of the episode (T) [s].
        lines: lines of the plot.
    """

    title: str
    unit: str
    time: Array
    lines: tuple[Line, ...]
