"""What a compiler says of generated code that it rejects."""

import re

from prp_gym.errors import GeneratedCodeError

FILE_NAME = "generated.c"
"""The name of the file that the compiler reads."""

_ERROR = re.compile(re.escape(FILE_NAME) + r":(\d+)(?::\d+)?: error: .*")
_FUNCTION = re.compile(
    r"[A-Za-z_][\w \t*]*?\b(\w+)\s*\("
)  # from the first column on: statements are indented
_MOST_LINES = 3
_LONGEST_LINE = 300  # characters


def find_rejection(compiler: str, source: str, messages: str) -> GeneratedCodeError | None:
    """The error for code that a compiler rejects; None where it complains of nothing in the code.

    Args:
        compiler: name of the compiler.
        source: generated C code.
        messages: what the compiler has written, in English.
    """
    found = list(_ERROR.finditer(messages))
    if not found:
        return None
    lines = (match.group(0)[:_LONGEST_LINE] for match in found[:_MOST_LINES])
    return GeneratedCodeError(function_at(source, int(found[0].group(1))), compiler, "\n".join(lines))


def function_at(source: str, line: int) -> str:
    """The name of the function to which a line belongs; empty outside of functions.

    Args:
        source: C code whose functions begin and end in the first column, as all generated code does.
        line: number of the line, from 1 on.
    """
    before = source.splitlines()[:line]
    for distance, text in enumerate(reversed(before)):
        match = _FUNCTION.match(text)
        if match:
            return match.group(1)
        if text.startswith("}") and distance > 0:
            return ""
    return ""
