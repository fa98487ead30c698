"""Copies of tables with some of their columns."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from rich.table import Table


def copy_table(
    table: Table, columns: Sequence[int], convert: Callable[[str], str] = lambda text: text
) -> Table:
    """A table of some columns of another one.

    Args:
        table: table to copy.
        columns: indices of the columns.
        convert: function that is applied to the title, the headers and the cells that are texts.
    """

    def converted(item: Any) -> Any:
        return convert(item) if isinstance(item, str) else item

    chosen = [table.columns[index] for index in columns]
    title = None if table.title is None else convert(str(table.title))
    made = Table(
        *(replace(column, header=converted(column.header), _index=0, _cells=[]) for column in chosen),
        title=title,
        title_justify=table.title_justify,
        box=table.box,
        pad_edge=table.pad_edge,
    )
    made.padding = table.padding
    for row in zip(*(column.cells for column in chosen), strict=True):
        made.add_row(*map(converted, row))
    return made
