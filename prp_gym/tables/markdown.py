"""Tables as Markdown, in the dialect of GitHub."""

import re

from prp_gym.tables.result_table import ResultTable

_SPECIAL = re.compile(r"([\\`*|<>]|\](?=\())")  # the last one would make a link


def to_markdown(table: ResultTable) -> str:
    """A table under its title in bold letters.

    Args:
        table: table to write.
    """
    header = [escape(column.label) for column in table.columns]
    rule = ["---:" if column.numeric else ":---" for column in table.columns]
    rows = [[escape(cell.text) for cell in row] for row in table.rows]
    lines = [f"| {' | '.join(row)} |" for row in (header, rule, *rows)]
    return "\n".join([f"**{escape(table.title)}**", "", *lines]) + "\n"


def escape(text: str) -> str:
    """A text in which no character has a meaning in Markdown, in one line."""
    return _SPECIAL.sub(r"\\\1", " ".join(text.split()))
