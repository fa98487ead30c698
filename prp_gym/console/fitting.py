"""Tables that are too wide for a console, in several parts below each other."""

from collections.abc import Sequence

from rich.console import Console
from rich.measure import Measurement
from rich.table import Column, Table

from prp_gym.console.table_copy import copy_table

_WRAPPED = 24  # columns that a cell of wrapped text gets at least, unless its text is shorter
_KEYS = 3  # columns of names that are repeated in every part, at most
_ROOM_OF_KEYS = 0.6  # share of the width that they may take


def fit(table: Table, console: Console) -> list[Table]:
    """A table in parts that fit into the width of a console, each with the columns of names.

    No cell is cut: a table is split between its columns. The columns of names are the first ones that are not
    aligned to the right. One column alone that is wider than the console is left as it is.

    Args:
        table: table whose headers and cells are texts.
        console: console that shows it.
    """
    needs = [_need(table, column, console) for column in table.columns]
    width = console.width - _edges(table)
    if sum(needs) <= width:
        return [table]
    keys = _keys(table.columns, needs, width)
    room = width - sum(needs[:keys])
    parts: list[list[int]] = [[]]
    used = 0
    for index in range(keys, len(needs)):
        if used + needs[index] > room and parts[-1]:
            parts.append([])
            used = 0
        parts[-1].append(index)
        used += needs[index]
    made = [copy_table(table, [*range(keys), *part]) for part in parts]
    for later in made[1:]:
        later.title = f"{table.title} (continued)" if table.title else None
    return made


def _keys(columns: Sequence[Column], needs: Sequence[int], width: int) -> int:
    """Number of the columns of names."""
    count = 1
    while (
        count < min(_KEYS, len(columns) - 1)
        and columns[count].justify == "left"
        and sum(needs[: count + 1]) <= _ROOM_OF_KEYS * width
    ):
        count += 1
    return count


def _need(table: Table, column: Column, console: Console) -> int:
    """Columns of the console that a column of the table needs, with the gap beside it."""
    found = [Measurement.get(console, console.options, item) for item in (column.header, *column.cells)]
    widest = max(item.maximum for item in found)
    if not column.no_wrap:
        widest = min(widest, max(_WRAPPED, max(item.minimum for item in found)), column.max_width or widest)
    _, right, _, left = table.padding
    return widest + left + right + (table.box is not None)


def _edges(table: Table) -> int:
    """Columns of the console that a table needs beside those of its columns."""
    _, right, _, left = table.padding
    return (table.box is not None) - (0 if table.pad_edge else left + right)
