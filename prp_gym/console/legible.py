"""Tables and streams of terminals that show ASCII alone."""

import codecs
import sys
from dataclasses import replace

from rich.console import Console

from prp_gym.tables import Cell, ResultTable, TableColumn
from prp_gym.tables.headings import SOFT_HYPHEN
from prp_gym.tables.legible_text import legible

ERRORS = "prp_gym.legible"
"""Name of the handler of characters that an encoding lacks."""


def is_unicode(console: Console) -> bool:
    """Whether a console shows every character."""
    return console.encoding.startswith("utf")


def legible_table(table: ResultTable) -> ResultTable:
    """A table in ASCII.

    Args:
        table: table whose title, headings, units and texts are converted; its values stay as they are.
    """
    columns = tuple(map(_legible_column, table.columns))
    rows = tuple(tuple(map(_legible_cell, row)) for row in table.rows)
    return ResultTable(legible(table.title), columns, rows)


def _legible_column(column: TableColumn) -> TableColumn:
    heading = SOFT_HYPHEN.join(map(legible, column.heading.split(SOFT_HYPHEN)))
    return replace(column, heading=heading, units=tuple(map(legible, column.units)))


def _legible_cell(cell: Cell) -> Cell:
    return replace(cell, text=legible(cell.text))


def write_legibly() -> None:
    """Let standard output and standard error replace what their encoding lacks, in place of an error."""
    codecs.register_error(ERRORS, _handle)
    for stream in (sys.stdout, sys.stderr):
        if not (getattr(stream, "encoding", None) or "utf-8").lower().startswith("utf"):
            getattr(stream, "reconfigure", _ignore)(errors=ERRORS)


def _ignore(**_: str) -> None:
    """For streams that are no text files."""


def _handle(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return legible(error.object[error.start : error.end]), error.end
