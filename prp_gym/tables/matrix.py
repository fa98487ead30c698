"""`matrix_table`: environments by names, one cell for each."""

from collections.abc import Iterable, Sequence

from prp_gym.tables.cell import Cell
from prp_gym.tables.column import TableColumn, text_column
from prp_gym.tables.result_table import ResultTable


def short_id(environment_id: str) -> str:
    """An environment's id without the prefix and version of the suite's ids."""
    return environment_id.removeprefix("PRP-").removesuffix("-v0")


def id_cell(environment_id: str) -> Cell:
    """The short form of an environment's id, with the whole id as value."""
    return Cell(short_id(environment_id), environment_id)


def matrix_table(title: str, names: Iterable[str], rows: Iterable[tuple[str, Sequence[Cell]]]) -> ResultTable:
    """A table of environments by controllers or other names.

    Args:
        title: what the cells say.
        names: headings of the columns, which a terminal breaks at underscores.
        rows: an environment's id with a cell for each name.
    """
    columns = (text_column("environment"), *(TableColumn(name) for name in names))
    return ResultTable.of(title, columns, [(id_cell(name), *cells) for name, cells in rows])
