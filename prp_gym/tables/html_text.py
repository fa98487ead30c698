"""Tables as HTML, for notebooks."""

from html import escape

from prp_gym.tables.result_table import ResultTable

_CAPTION = "caption-side: top; text-align: left; font-weight: bold; white-space: nowrap"


def to_html(table: ResultTable) -> str:
    """A table with its title as caption; every text is escaped.

    Args:
        table: table to write.
    """
    alignments = ["right" if column.numeric else "left" for column in table.columns]
    header = _row("th", [column.label for column in table.columns], alignments)
    rows = "".join(_row("td", [cell.text for cell in row], alignments) for row in table.rows)
    return (
        f'<table><caption style="{_CAPTION}">{escape(table.title)}</caption>'
        f"<thead>{header}</thead><tbody>{rows}</tbody></table>"
    )


def _row(kind: str, texts: list[str], alignments: list[str]) -> str:
    cells = zip(texts, alignments, strict=True)
    shown = (f'<{kind} style="text-align: {side}">{escape(text)}</{kind}>' for text, side in cells)
    return f"<tr>{''.join(shown)}</tr>"
