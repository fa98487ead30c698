"""`draw_learning_curve`: the training of one agent as a figure."""

from typing import TYPE_CHECKING

from prp_gym.figures.figure_file import new_figure
from prp_gym.palette import BLUE, LIGHT_GRAY
from prp_gym.robot.arrays import Array

if TYPE_CHECKING:
    from prp_gym.figures.notebook_figure import NotebookFigure

_SIZE = (6.0, 3.6)  # [inches]
_ROOM = 1.02  # of a scale of 0 to 1


def draw_learning_curve(title: str, simulated_seconds: Array, score: Array) -> "NotebookFigure":
    """Score on held-out episodes against simulated time; the best one is labelled.

    Args:
        title: title of the figure.
        simulated_seconds: simulated time of the training until each evaluation (n) [s].
        score: mean reward over the held-out episodes (n) [1].

    Returns:
        a figure of matplotlib; `savefig` writes it as PNG, SVG or PDF.
    """
    figure = new_figure(*_SIZE)
    axes = figure.subplots()
    axes.plot(simulated_seconds, score, "-o", color=BLUE, markersize=4, linewidth=1.5)
    if len(score):
        best = int(score.argmax())
        axes.annotate(
            f"{score[best]:.3f}",
            (float(simulated_seconds[best]), float(score[best])),
            xytext=(0, -14),
            textcoords="offset points",
            ha="center",
        )
    axes.set(xlabel="simulated time [s]", ylabel="score on held-out episodes [1]", ylim=(0.0, _ROOM))
    axes.grid(True, color=LIGHT_GRAY, linewidth=0.5)
    figure.suptitle(title, fontsize=10)
    return figure
