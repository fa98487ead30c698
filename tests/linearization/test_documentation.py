"""The example of the documentation prints what stands there."""

import contextlib
import io
import re
from pathlib import Path

from tests.support.compiler import needs_compiler

pytestmark = needs_compiler

PAGE = Path(__file__).resolve().parents[2] / "docs" / "linearization.md"


def test_the_example_prints_what_the_page_shows() -> None:
    text = PAGE.read_text(encoding="utf-8")
    (program,) = re.findall(r"```python\n(.*?)```", text, flags=re.DOTALL)
    (shown,) = re.findall(r"```text\n(.*?)```", text, flags=re.DOTALL)
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(program, str(PAGE), "exec"), {})
    assert printed.getvalue() == shown
