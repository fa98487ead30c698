"""Text for comments of source code in ASCII, which every compiler of microcontrollers reads."""

import re
import unicodedata

_SIGNS = {
    "·": " ",
    "±": "+-",
    "∞": "inf",
    "≤": "<=",
    "≥": ">=",
    "²": "^2",
    "³": "^3",
    "ᵀ": "^T",
    "⁻": "^-",
    "√": "sqrt ",
    "∫": "integral ",
    "→": "->",
    "–": "-",
    "—": "-",
    "…": "...",
    "‘": "'",
    "’": "'",
}
_DERIVATIVES = {"\u0307": "d{}/dt", "\u0308": "d2{}/dt2"}
_DOTTED = re.compile("(\\w)([\u0307\u0308])(_\\w+)?")
_IN_COMMENTS = {"*/": "* /", "/*": "/ *", "??": "? ?"}
"""What would end a comment, begin one in it, or be read as a trigraph."""


def comment_text(text: str) -> str:
    """A text on one line in ASCII, as it may stand in a comment of C.

    Time derivatives are written out (`dq/dt`), Greek letters are named, and what has no form in ASCII
    becomes `_`.

    Args:
        text: any text.
    """
    plain = unicodedata.normalize("NFD", re.sub(r"\s", " ", text))
    plain = _DOTTED.sub(lambda match: _DERIVATIVES[match[2]].format(match[1] + (match[3] or "")), plain)
    plain = "".join(letter if letter.isascii() else _named(letter) for letter in plain)
    plain = "".join(letter if letter.isprintable() else "_" for letter in plain)
    for before, after in _IN_COMMENTS.items():
        while before in plain:
            plain = plain.replace(before, after)
    return plain


def _named(letter: str) -> str:
    if letter in _SIGNS:
        return _SIGNS[letter]
    name = unicodedata.name(letter, "")
    if name.startswith("GREEK "):
        return name.rpartition(" ")[2].lower()
    return "" if unicodedata.combining(letter) else "_"
