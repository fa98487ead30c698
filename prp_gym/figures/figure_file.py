"""Figures as files: PNG, and SVG or PDF as vector graphics, the kind by the suffix of the file."""

import io
from pathlib import Path
from typing import TYPE_CHECKING, Any

from prp_gym.artifacts import write_file
from prp_gym.errors import InvalidValueError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from prp_gym.figures.notebook_figure import NotebookFigure

SUFFIXES = (".png", ".svg", ".pdf")
"""Suffixes of the files in which figures can be written."""

_DPI = 100
_FILE_SETTINGS: Any = {
    "pdf.fonttype": 42,  # letters as outlines of TrueType: journals refuse bitmaps
    "svg.fonttype": "none",  # text stays text, which can be searched and edited
    "svg.hashsalt": "prp_gym",  # equal figures give equal files
}
_UNDATED: dict[str, dict[str, Any]] = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}, ".png": {}}


def new_figure(width: float, height: float) -> "NotebookFigure":
    """An empty figure without a window.

    Args:
        width: width of the figure [inches].
        height: height of the figure [inches].
    """
    from prp_gym.figures.notebook_figure import NotebookFigure  # on use: the package stays light

    return NotebookFigure(figsize=(width, height), dpi=_DPI, layout="constrained")


def check_suffix(path: Path) -> str:
    """The suffix of a figure's file in small letters.

    Raises:
        InvalidValueError: a suffix of which no figure can be written.
    """
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise InvalidValueError("file of a figure", str(path), f"a name that ends in {', '.join(SUFFIXES)}")
    return suffix


def figure_content(figure: "Figure", suffix: str) -> bytes:
    """The content of a file of a figure; the same figure gives the same bytes.

    Args:
        figure: figure to write.
        suffix: one of `SUFFIXES`.
    """
    from matplotlib import rc_context

    target = io.BytesIO()
    with rc_context(_FILE_SETTINGS):
        figure.savefig(target, format=suffix[1:], metadata=_UNDATED[suffix])
    return target.getvalue()


def write_figure(path: Path, figure: "Figure") -> None:
    """Write a figure, as pixels or as vector graphics by the suffix of the file.

    Args:
        path: path of the file; its folder is made if it does not exist.
        figure: figure to write.

    Raises:
        InvalidValueError: a suffix of which no figure can be written.
        OutputError: the folder cannot be made or written to.
    """
    write_file(path, figure_content(figure, check_suffix(path)))
