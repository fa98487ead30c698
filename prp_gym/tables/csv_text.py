"""Tables as CSV with exact values (RFC 4180)."""

import csv
import io
from typing import Any

from prp_gym.tables.column import TableColumn
from prp_gym.tables.result_table import ResultTable


def to_csv(table: ResultTable) -> str:
    """A table with a header line; the parts of a value have columns of their own.

    Args:
        table: table to write; its title is not part of the text.

    Returns:
        lines that end in CR LF; values that there are not are empty.
    """
    target = io.StringIO(newline="")
    writer = csv.writer(target)
    writer.writerow([field for column in table.columns for field in column.fields])
    for row in table.rows:
        cells = zip(table.columns, row, strict=True)
        writer.writerow([value for column, cell in cells for value in _values(column, cell.plain)])
    return target.getvalue()


def _values(column: TableColumn, value: Any) -> list[Any]:
    """The values of a cell, one for each field of its column."""
    values = list(value) if isinstance(value, list) else [value]
    missing = len(column.fields) - len(values)
    return ["" if item is None else item for item in values] + [""] * missing
