"""`show_tables`: how every command prints its tables and the notes below them."""

from collections.abc import Iterable, Sequence

import typer

from prp_gym.runs.terminal import make_console
from prp_gym.tables import ResultTable
from prp_gym.tables.formats import TERMINAL, write_tables

_LEAST_WIDTH = 80  # columns for which every name and number has room


def show_tables(tables: Sequence[ResultTable], notes: Iterable[str], form: str) -> None:
    """Print tables in a form, and notes below them.

    Args:
        tables: tables to print.
        notes: lines for people; in a form for programs they go to standard error.
        form: name of the form of the tables, one of `FORMATS`.
    """
    console = make_console(stderr=form != TERMINAL, least=_LEAST_WIDTH)
    if form == TERMINAL:
        for table in tables:
            console.print(table)
    else:
        typer.echo(write_tables(tables, form), nl=False)
    for note in notes:
        console.print(note, markup=False, highlight=False)
