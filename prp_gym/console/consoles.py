"""Consoles of standard output and standard error."""

import os

from rich.console import Console

WIDTH = 120
"""Columns of what is not a terminal, such as a file, unless the variable COLUMNS says otherwise."""

LEAST_WIDTH = 60
"""Columns that a console has at least."""


def make_console(stderr: bool = False, least: int = LEAST_WIDTH) -> Console:
    """A console of the width of the terminal, or of COLUMNS, or of 120 columns without both.

    Args:
        stderr: whether it writes to standard error in place of standard output.
        least: columns that it has at least; a narrower terminal breaks the lines itself.
    """
    made = Console(stderr=stderr)
    known = made.is_terminal or os.environ.get("COLUMNS", "").isdecimal()
    made.width = max(made.width if known else WIDTH, least)
    return made
