"""Text for comments of C, in ASCII, which every compiler of microcontrollers reads."""

import re

from prp_gym.tables.legible_text import legible

_IN_COMMENTS = {"*/": "* /", "/*": "/ *", "??": "? ?"}
"""What would end a comment, begin one in it, or be read as a trigraph."""


def comment_text(text: str) -> str:
    """A text on one line in ASCII, as it may stand in a comment of C: `q̇` is `q_dot`.

    Args:
        text: any text.
    """
    plain = legible(re.sub(r"\s", " ", text))
    plain = "".join(letter if letter.isprintable() else "?" for letter in plain)
    for before, after in _IN_COMMENTS.items():
        while before in plain:
            plain = plain.replace(before, after)
    return plain
