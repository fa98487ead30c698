"""Tables for the terminal: as wide as their cells, in several parts where a terminal is narrower."""

from collections.abc import Sequence

from rich.box import SIMPLE_HEAD, Box
from rich.table import Table
from rich.text import Text

from prp_gym.tables.cell import Cell
from prp_gym.tables.column import TableColumn
from prp_gym.tables.headings import fold_heading, fold_name, longest_piece
from prp_gym.tables.result_table import ResultTable

ASCII_BOX = Box("    \n    \n -- \n    \n    \n    \n    \n    \n", ascii=True)
"""Lines of a table for a terminal that shows ASCII alone, as wide as those of `SIMPLE_HEAD`."""

_GAP = 2  # characters between columns, and of both edges together
_NAMES_AT_MOST = 0.6  # of the width
_WRAPPED = 24  # characters that a column of sentences gets at least, unless its text is shorter
_STYLES = {"": "", "good": "green", "warning": "yellow", "bad": "bold red"}


def terminal_tables(table: ResultTable, width: int, box: Box = SIMPLE_HEAD) -> list[Table]:
    """The parts in which a table fits a terminal, without its title; each begins with the columns of names.

    Args:
        table: table to show.
        width: columns of the terminal.
        box: lines of the table, as wide as those of `SIMPLE_HEAD`.
    """
    cells = [[_text(column, row[index]) for row in table.rows] for index, column in enumerate(table.columns)]
    widths = [_width(column, own) for column, own in zip(table.columns, cells, strict=True)]
    names = _leading_names(table.columns, widths, width)
    room = width - sum(widths[index] + _GAP for index in range(names))
    chosen = _fitting([own + _GAP for own in widths[names:]], room)
    parts = [
        _part(table, cells, widths, [*range(names), *(names + index for index in part)]) for part in chosen
    ]
    for part in parts:
        part.box = box
    return parts


def _leading_names(columns: Sequence[TableColumn], widths: Sequence[int], width: int) -> int:
    """How many columns of names every part begins with: one at least, and no more than leave room."""
    count = next((index for index, column in enumerate(columns) if column.numeric), len(columns))
    while count > 1 and (count == len(columns) or sum(widths[:count]) > _NAMES_AT_MOST * width):
        count -= 1
    return min(1, len(columns)) if count == 0 else count


def _part(
    table: ResultTable, cells: Sequence[Sequence[Text]], widths: Sequence[int], chosen: Sequence[int]
) -> Table:
    """Some columns of a table."""
    wrapped = any(table.columns[index].wraps for index in chosen)
    made = Table(pad_edge=False, padding=(0, _GAP - 1, 0, 0))
    for index in chosen:
        column = table.columns[index]
        made.add_column(
            _header(column, widths[index]),
            justify="right" if column.numeric else "left",
            no_wrap=not column.wraps,
            overflow="fold",
            vertical="top" if wrapped else "bottom",  # of headings with several lines
        )
    for row in zip(*(cells[index] for index in chosen), strict=True):
        made.add_row(*row)
    return made


def _text(column: TableColumn, cell: Cell) -> Text:
    """A cell's text, a long name in several lines."""
    return Text(fold_name(cell.text, column.width) if column.width else cell.text, style=_STYLES[cell.tone])


def _width(column: TableColumn, cells: Sequence[Text]) -> int:
    """Characters of the longest line of a column; of sentences, those that they get at least."""
    head = (longest_piece(column.heading), len(" ".join(column.shown_units)))
    longest = max(*head, *(len(line) for cell in cells for line in cell.plain.split("\n")), 1)
    if not column.wraps:
        return longest
    words = (len(word) for cell in cells for word in cell.plain.split())
    return min(longest, max(_WRAPPED, *head, *words))


def _header(column: TableColumn, width: int) -> Text:
    """The heading in lines of a width, above the units."""
    heading = [column.title] if column.wraps else fold_heading(column.heading, width)
    return Text("\n".join([*heading, *_unit_line(column)]))


def _unit_line(column: TableColumn) -> list[str]:
    return [" ".join(column.shown_units)] if column.units else []


def _fitting(widths: Sequence[int], room: int) -> list[range]:
    """The columns in parts whose widths fit into a room, each with at least one column."""
    starts, used = [0], 0
    for index, width in enumerate(widths):
        if used + width > room and index > starts[-1]:
            starts.append(index)
            used = 0
        used += width
    return [range(start, end) for start, end in zip(starts, [*starts[1:], len(widths)], strict=True)]
