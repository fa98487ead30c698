"""What a command says on a machine without compiled code, or with a compiler that does not work."""

from collections.abc import Sequence

from prp_gym.console.terminal import Terminal
from prp_gym.errors import CompilerError
from prp_gym.symbolic.compiler import is_turned_off, require_compiled_code


def note_missing_compiler(terminal: Terminal, more: Sequence[str] = ()) -> None:
    """Write one line where NumPy stands in for compiled code that the machine lacks.

    Args:
        terminal: terminal of the command.
        more: what else is said of it, in any case.
    """
    for line in more:
        terminal.note(line)
    if is_turned_off():
        return
    try:
        require_compiled_code()
    except CompilerError as error:
        terminal.note(f"{error} NumPy computes the same results; a step takes up to 2.5 times as long.")
