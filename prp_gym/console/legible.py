"""Texts for terminals that show ASCII alone: legible replacements of all other characters."""

import codecs
import sys
import unicodedata
from dataclasses import replace

from rich.console import Console

from prp_gym.tables import Cell, ResultTable, TableColumn
from prp_gym.tables.headings import SOFT_HYPHEN

ERRORS = "prp_gym.legible"
"""Name of the handler of characters that an encoding lacks."""

_ASCII, _END_OF_NAMES = 0x80, 0x180  # first code points beyond ASCII and Latin Extended-A

_LETTERS = """
µ u  μ u  ² ^2  ³ ^3  ⁻ ^-  ¹ ^1  ° deg  ± +/-  ½ 1/2  ₑ _e
≤ <=  ≥ >=  ≠ !=  ≈ ~  → ->  ← <-  × x  √ sqrt  ∞ inf  ∫ integral  Σ sum  ∂ d  ∈ in
– -  — -  − -  … ...  ‖ ||  “ "  ” "  ‘ '  ’ '  • *  ✓ yes  ✗ no
─ -  ━ -  │ |  ┃ |  ╭ +  ╮ +  ╰ +  ╯ +  ┌ +  ┐ +  └ +  ┘ +  ├ +  ┤ +  ┬ +  ┴ +  ┼ +
"""
_REPLACED = {
    **dict(zip(_LETTERS.split()[::2], _LETTERS.split()[1::2], strict=True)),
    "·": " ",
    "\u00a0": " ",
    "\u0301": "",
    "\u0300": "",
    "\u0307": "_dot",
    "\u0308": "_ddot",
    "\u0302": "_hat",
    "\u0304": "_bar",
    "\u0303": "_tilde",
}
"""Characters with their replacements; those of the last lines combine with the letter before them."""


def is_unicode(console: Console) -> bool:
    """Whether a console shows every character."""
    return console.encoding.startswith("utf")


def legible(text: str) -> str:
    """A text in ASCII: `ẋ` is `x_dot`, `m²` is `m^2`, `γ` is `gamma`."""
    if text.isascii():
        return text
    return "".join(map(_letter, text))


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


def _letter(letter: str) -> str:
    """One character in ASCII."""
    if ord(letter) < _ASCII:
        return letter
    if letter in _REPLACED:
        return _REPLACED[letter]
    name = unicodedata.name(letter, "")
    if name.startswith("GREEK") and " WITH " not in name:
        word = name.rpartition(" ")[2].lower()
        return word.capitalize() if "CAPITAL" in name else word
    parts = unicodedata.normalize("NFKD", letter)
    if ord(letter) < _END_OF_NAMES:  # a letter of a name, whose accents are no derivatives
        parts = parts[0]
    return "?" if parts == letter else "".join(map(_letter, parts))
