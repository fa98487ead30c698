"""The terminal: consoles, progress bars and tables by environment and controller."""

from collections.abc import Iterable, Sequence

from rich.box import SIMPLE_HEAD
from rich.table import Table

from prp_gym.runs.progress import TABLE_WIDTH, make_console, make_progress

__all__ = ["TABLE_WIDTH", "make_console", "make_matrix", "make_progress"]

_GAP = 1  # between columns of a matrix


def make_matrix(
    title: str, controllers: Iterable[str], rows: Iterable[tuple[str, Sequence[str]]]
) -> list[Table]:
    """Tables of environments by controllers, as many as are needed to fit 120 columns.

    Names of controllers are broken at underscores.

    Args:
        title: of the first table.
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
