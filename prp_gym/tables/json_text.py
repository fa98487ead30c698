"""Tables as JSON with exact values."""

import json
from collections.abc import Sequence
from typing import Any

from prp_gym.tables.result_table import ResultTable


def to_json(tables: Sequence[ResultTable]) -> str:
    """Tables as a list of objects with title, columns and rows; a row is an object by column.

    Args:
        tables: tables to write.
    """
    return json.dumps(plain_tables(tables), indent=2, ensure_ascii=False, allow_nan=False)


def plain_tables(tables: Sequence[ResultTable]) -> list[dict[str, Any]]:
    """Tables in the types of strict JSON.

    Args:
        tables: tables with exact values.
    """
    return [_plain(table) for table in tables]


def _plain(table: ResultTable) -> dict[str, Any]:
    columns = [
        {
            "key": key,
            "title": column.title,
            "units": list(column.units),
            "parts": list(column.parts),
        }
        for key, column in zip(table.keys, table.columns, strict=True)
    ]
    return {"title": table.title, "columns": columns, "rows": table.records}
