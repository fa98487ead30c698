"""Headings and names in lines of a limited width."""

import re

SOFT_HYPHEN = "\u00ad"
"""Character at which a word of a heading may be broken; invisible elsewhere."""

_BREAKS = re.compile(r"[ _]|-(?=[A-Za-z])")  # no minus sign is left behind


def without_breaks(heading: str) -> str:
    """A heading in one line, without its soft hyphens."""
    return heading.replace(SOFT_HYPHEN, "")


def longest_piece(heading: str) -> int:
    """Number of characters of the longest part of a heading that is never broken, with its hyphen."""
    return max(len(_shown(piece)) for piece in _pieces(heading))


def fold_heading(heading: str, width: int) -> list[str]:
    """A heading in lines of a width, as few as there can be.

    Args:
        heading: words with soft hyphens where they may be broken.
        width: largest number of characters of a line; longer parts have a line of their own.
    """
    lines, line = [], ""
    for piece in _pieces(heading):
        if line and len(_shown(line + piece)) > width:
            lines.append(_shown(line))
            line = ""
        line += piece
    return [*lines, _shown(line)]


def fold_name(name: str, width: int) -> str:
    """A name in lines of a width, broken after a space, an underscore or a hyphen where there is one."""
    lines = []
    while len(name) > width:
        breaks = [found.end() for found in _BREAKS.finditer(name, 0, width)]
        end = width if name[width] == " " or not breaks else breaks[-1]
        lines.append(name[:end].rstrip())
        name = name[end:].lstrip()
    return "\n".join([*lines, name])


def _pieces(heading: str) -> list[str]:
    """The parts of a heading: words with their space, and parts of words with what follows them."""
    marked = re.sub(rf"([ _-]|{SOFT_HYPHEN})", "\\1\n", heading)
    return marked.split("\n")


def _shown(line: str) -> str:
    """A line as it is printed: a soft hyphen is seen at its end alone."""
    line = line.rstrip()
    return without_breaks(line) + "-" * line.endswith(SOFT_HYPHEN)
