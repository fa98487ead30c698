"""Which function a compiler's message is about."""

import pytest

from prp_gym.symbolic.diagnostics import find_rejection, function_at

SOURCE = """#include <math.h>

static inline void prp_first(
    const double *restrict angle,
    double *restrict angle)
{
    const double t0 = sin(angle[0]);
    angle[0] = t0;
}

double constant = 1.0
static const double *second(void) {
    return constant;
}
"""


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        (1, ""),
        (3, "prp_first"),
        (5, "prp_first"),
        (7, "prp_first"),
        (9, "prp_first"),
        (10, ""),
        (11, ""),
        (12, "second"),
        (13, "second"),
    ],
)
def test_line_belongs_to_the_function_around_it(line: int, expected: str) -> None:
    assert function_at(SOURCE, line) == expected


@pytest.mark.parametrize(
    ("messages", "lines"),
    [
        (  # gcc
            "/tmp/a/generated.c: In function 'prp_first':\n"
            "/tmp/a/generated.c:5:22: error: redefinition of parameter 'angle'\n"
            "    5 |     double *restrict angle)\n"
            "/tmp/a/generated.c:4:28: note: previous definition of 'angle' was here\n",
            ["generated.c:5:22: error: redefinition of parameter 'angle'"],
        ),
        (  # tcc, without columns
            "/tmp/a/generated.c:7: error: ';' expected\n",
            ["generated.c:7: error: ';' expected"],
        ),
        (  # clang, with many
            "".join(f"/tmp/a/generated.c:7:{column}: error: wrong\n" for column in range(9)),
            [f"generated.c:7:{column}: error: wrong" for column in range(3)],
        ),
    ],
)
def test_first_errors_are_told_with_the_function(messages: str, lines: list[str]) -> None:
    found = find_rejection("cc", SOURCE, messages)
    assert found is not None
    assert (found.function, found.compiler) == ("prp_first", "cc")
    assert found.messages.splitlines() == lines


@pytest.mark.parametrize(
    "messages",
    [
        "",
        "cc: error: unrecognized command-line option '-fno-builtin-pow'",
        "/tmp/a/generated.c:1:10: fatal error: math.h: No such file or directory",
        "cc: fatal error: Killed signal terminated program cc1",
        "/tmp/a/generated.c:7:3: warning: unused variable",
    ],
)
def test_what_is_not_about_the_code_is_no_rejection(messages: str) -> None:
    assert find_rejection("cc", SOURCE, messages) is None
