"""`Curve` and `Panel`: the content of a figure as data, before it is drawn."""

from dataclasses import dataclass

from prp_gym.robot.arrays import Array


@dataclass(frozen=True, eq=False)
class EpisodeCurve:
    """One line of a panel.

    Attributes:
        label: symbol of the quantity for the legend (mathematical text).
        component: number of the component from 0, which sets colour and marker.
        role: what the line shows: `actual`, `reference` or `model`, which sets the line style.
        values: values over time (n), in the unit of the panel.
    """

    label: str
    component: int
    role: str
    values: Array


@dataclass(frozen=True, eq=False)
class EpisodePanel:
    """The content of one pair of axes over time.

    Attributes:
        quantity: name of the quantity with its unit, as the vertical axis has it.
        curves: lines of the panel.
        limits: symmetric bounds of the curves and their labels, drawn as horizontal lines.
        fixed_range: lower and upper end of the vertical axis; empty to fit the curves.
    """

    quantity: str
    curves: tuple[EpisodeCurve, ...]
    limits: tuple[tuple[str, float], ...] = ()
    fixed_range: tuple[float, float] | tuple[()] = ()
