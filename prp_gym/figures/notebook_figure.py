"""`NotebookFigure`: a figure of matplotlib without a window, which notebooks show."""

import io
from typing import Any

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure


class NotebookFigure(Figure):
    """A figure that belongs to no window and to no list of open figures.

    Args:
        options: arguments of matplotlib's `Figure`.
    """

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        FigureCanvasAgg(self)

    def _repr_png_(self) -> bytes:
        """The figure as a notebook shows it."""
        target = io.BytesIO()
        self.savefig(target, format="png")
        return target.getvalue()
