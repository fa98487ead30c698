"""The terminal: consoles and progress bars."""

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

TABLE_WIDTH = 120
"""Columns of a table where there is no terminal."""


def make_console(stderr: bool = False, least: int = 0) -> Console:
    """A console of the terminal's width, or of 120 columns without one; a table may need it wider."""
    made = Console(stderr=stderr)
    made.width = max(made.width if made.is_terminal else TABLE_WIDTH, least)
    return made


def make_progress() -> Progress:
    """A bar that counts, and leaves nothing behind."""
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    return Progress(*columns, console=make_console(stderr=True), transient=True)
