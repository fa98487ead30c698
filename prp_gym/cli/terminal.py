"""The terminal: width, and progress on standard error."""

from collections.abc import Iterable, Sequence

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

TABLE_WIDTH = 120


def make_console(stderr: bool = False, least: int = 0) -> Console:
    """A console of the terminal's width, or of 120 columns without one; a table may need it wider."""
    made = Console(stderr=stderr)
    made.width = max(made.width if made.is_terminal else TABLE_WIDTH, least)
    return made


def make_progress() -> Progress:
    """A bar that counts, and leaves nothing behind."""
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    return Progress(*columns, console=make_console(stderr=True), transient=True)


def make_matrix(title: str, controllers: Iterable[str], rows: Iterable[tuple[str, Sequence[str]]]) -> Table:
    """A table of environments by laws, whose names are broken at underscores to fit 120 columns.

    Args:
        title: of the table.
        controllers: names of the columns.
        rows: an environment's id with a cell a law.
    """
    table = Table(title=title, title_justify="left", box=SIMPLE_HEAD, pad_edge=False, padding=0)
    table.add_column("environment", no_wrap=True)
    for name in controllers:
        table.add_column(name.replace("_", "\n"), justify="center", no_wrap=True)
    for environment_id, cells in rows:
        table.add_row(environment_id.removeprefix("PRP-").removesuffix("-v0"), *cells)
    return table
