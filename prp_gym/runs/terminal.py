"""The terminal: consoles, progress bars and tables by environment and controller."""

from collections.abc import Iterable, Sequence

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

TABLE_WIDTH = 120
"""Columns for which tables are made."""

_GAP = 1  # between columns of a matrix


def make_console(stderr: bool = False, least: int = 0) -> Console:
    """A console of the terminal's width, or of 120 columns without one; a table may need it wider."""
    made = Console(stderr=stderr)
    made.width = max(made.width if made.is_terminal else TABLE_WIDTH, least)
    return made


def make_progress() -> Progress:
    """A bar that counts, and leaves nothing behind."""
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    return Progress(*columns, console=make_console(stderr=True), transient=True)


def make_matrix(
    title: str, controllers: Iterable[str], rows: Iterable[tuple[str, Sequence[str]]]
) -> list[Table]:
    """Tables of environments by controllers, as many as are needed to fit 120 columns.

    Names of controllers are broken at underscores.

    Args:
        title: title of the first table.
        controllers: names of the columns.
        rows: an environment's id with a cell for each controller.
    """
    named = [(_short(environment_id), cells) for environment_id, cells in rows]
    names, tables = list(controllers), []
    widths = [
        max(map(len, [*name.split("_"), *(own[index] for _, own in named)])) + _GAP
        for index, name in enumerate(names)
    ]
    room = TABLE_WIDTH - max([len("environment"), *(len(name) for name, _ in named)]) - _GAP
    for part in _fitting(widths, room):
        table = Table(title=title, title_justify="left", box=SIMPLE_HEAD, pad_edge=False, padding=0)
        table.add_column("environment", no_wrap=True)
        for name in names[part]:
            table.add_column(name.replace("_", "\n"), justify="center", no_wrap=True)
        for name, own in named:
            table.add_row(name, *own[part])
        tables.append(table)
        title = ""
    return tables


def _short(environment_id: str) -> str:
    return environment_id.removeprefix("PRP-").removesuffix("-v0")


def _fitting(widths: Sequence[int], room: int) -> list[slice]:
    """The columns in parts whose widths fit into a room, each with at least one column."""
    starts, used = [0], 0
    for index, width in enumerate(widths):
        if used + width > room and index > starts[-1]:
            starts.append(index)
            used = 0
        used += width
    return [slice(start, end) for start, end in zip(starts, [*starts[1:], len(widths)], strict=True)]
