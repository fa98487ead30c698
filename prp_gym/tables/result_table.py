"""`ResultTable`: a table as a value, from which every form of it is written."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Self

from prp_gym.errors import InvalidValueError, ShapeError
from prp_gym.tables.cell import Cell
from prp_gym.tables.column import TableColumn

if TYPE_CHECKING:
    from rich.console import Console, ConsoleOptions, RenderResult


@dataclass(frozen=True)
class ResultTable:
    """A table of results.

    Attributes:
        title: what the table shows, and of what.
        columns: columns of the table, each with a heading of its own.
        rows: rows of the table, each with one cell for every column.

    Raises:
        InvalidValueError: two columns with the same heading.
        ShapeError: a row with another number of cells than there are columns.
    """

    title: str
    columns: tuple[TableColumn, ...]
    rows: tuple[tuple[Cell, ...], ...]

    def __post_init__(self) -> None:
        labels = [column.label for column in self.columns]
        for label in labels:
            if labels.count(label) > 1:
                raise InvalidValueError(f"columns of table {self.title!r}", label, "each heading once")
        for row in self.rows:
            if len(row) != len(self.columns):
                expected = f"({len(self.columns)},), one cell for each column"
                raise ShapeError(f"row of table {self.title!r}", (len(row),), expected)

    @classmethod
    def of(cls, title: str, columns: Sequence[TableColumn], rows: Iterable[Sequence[Cell | str]]) -> Self:
        """A table of cells and plain texts.

        Args:
            title: what the table shows.
            columns: columns of the table.
            rows: rows of cells; a text stands for a cell with that text and value.
        """
        cells = (tuple(entry if isinstance(entry, Cell) else Cell.of(entry) for entry in row) for row in rows)
        return cls(title, tuple(columns), tuple(cells))

    @property
    def keys(self) -> list[str]:
        """Names of the columns for programs, each once."""
        found: list[str] = []
        for column in self.columns:
            count = sum(key.startswith(column.key) for key in found)
            found.append(f"{column.key}_{count + 1}" if column.key in found else column.key)
        return found

    @property
    def records(self) -> list[dict[str, Any]]:
        """The values of every row by column, in the types of strict JSON."""
        return [dict(zip(self.keys, (cell.plain for cell in row), strict=True)) for row in self.rows]

    def __rich_console__(self, console: "Console", options: "ConsoleOptions") -> "RenderResult":
        """The table for a terminal, in as many parts as its width needs."""
        from rich.box import SIMPLE_HEAD
        from rich.text import Text

        from prp_gym.tables.terminal import ASCII_BOX, terminal_tables

        box = ASCII_BOX if options.ascii_only else SIMPLE_HEAD
        for number, part in enumerate(terminal_tables(self, options.max_width, box)):
            yield Text(f"{self.title} (continued)" if number else self.title, style="italic")
            yield part

    def _repr_html_(self) -> str:
        """The table for a notebook."""
        from prp_gym.tables.html_text import to_html

        return to_html(self)
