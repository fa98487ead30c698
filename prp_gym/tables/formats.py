"""The forms of tables that `--format` names, beside that of the terminal."""

from collections.abc import Callable, Sequence

from prp_gym.checks import choice
from prp_gym.tables.csv_text import to_csv
from prp_gym.tables.json_text import to_json
from prp_gym.tables.latex import to_latex
from prp_gym.tables.markdown import to_markdown
from prp_gym.tables.result_table import ResultTable

TERMINAL = "table"
"""Name of the form for the terminal."""

JSON = "json"
"""Name of the form for programs that read exact values."""

_FORMS: dict[str, Callable[[Sequence[ResultTable]], str]] = {
    "md": lambda tables: "\n".join(map(to_markdown, tables)),
    "latex": lambda tables: "\n".join(map(to_latex, tables)),
    "csv": lambda tables: "\r\n".join(map(to_csv, tables)),
    JSON: lambda tables: f"{to_json(tables)}\n",
}

FORMATS = (TERMINAL, *_FORMS)
"""Names of the forms of tables."""


def write_tables(tables: Sequence[ResultTable], form: str) -> str:
    """Tables in one of the forms for files; several stand one after the other, with an empty line between.

    Args:
        tables: tables to write.
        form: name of the form, one of `FORMATS` without that of the terminal.

    Raises:
        UnknownNameError: another form.
    """
    return _FORMS[choice("format of tables", form, _FORMS)](tables)
