"""Tables as LaTeX, for the package booktabs."""

import re

from prp_gym.tables.result_table import ResultTable

_SPECIAL = {
    "\\": r"\textbackslash{}",
    "&": r"\&",
    "%": r"\%",
    "$": r"\$",
    "#": r"\#",
    "_": r"\_",
    "{": r"\{",
    "}": r"\}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "|": r"\textbar{}",
    '"': r"\textquotedbl{}",
    "µ": r"\textmu{}",
    "·": r"$\cdot$",
    "²": r"$^2$",
    "³": r"$^3$",
    "γ": r"$\gamma$",
    "τ": r"$\tau$",
    "→": r"$\rightarrow$",
    "±": r"$\pm$",
    "≥": r"$\geq$",
    "≤": r"$\leq$",
}
_NEGATIVE = re.compile(r"(?<![\w.-])-(?=\d)")
_INTERVAL = re.compile(r"(?<=\d)-(?=\d)")


def to_latex(table: ResultTable) -> str:
    r"""A table with its title as caption, for a document with \usepackage{booktabs}.

    Args:
        table: table to write.
    """
    form = "".join("r" if column.numeric else "l" for column in table.columns)
    header = " & ".join(escape(column.label) for column in table.columns)
    rows = [
        " & ".join(
            _number(cell.text) if column.numeric else escape(cell.text)
            for column, cell in zip(table.columns, row, strict=True)
        )
        for row in table.rows
    ]
    lines = [
        r"\begin{table}",
        r"\centering",
        rf"\caption{{{escape(table.title)}}}",
        rf"\begin{{tabular}}{{{form}}}",
        r"\toprule",
        rf"{header} \\",
        r"\midrule",
        *(rf"{{}}{row} \\" if row.startswith("[") else rf"{row} \\" for row in rows),
        r"\bottomrule",
        r"\end{tabular}",
        r"\end{table}",
    ]
    return "\n".join(lines) + "\n"


def escape(text: str) -> str:
    """A text in which no character has a meaning in LaTeX, in one line."""
    return "".join(_SPECIAL.get(character, character) for character in " ".join(text.split()))


def _number(text: str) -> str:
    """A text of numbers with minus signs, and with dashes in intervals."""
    if text == "-":
        return "--"
    return _INTERVAL.sub("--", _NEGATIVE.sub("$-$", escape(text)))
