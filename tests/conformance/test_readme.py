"""README's commands and Python blocks run one after the other, in the environment that they create.

Above a block, `<!-- test: A => B -->` declares a short form for what takes minutes: B replaces A in the test.
`<!-- file: NAME -->` declares a block as the content of a file that a later block reads, and
`<!-- not tested: WHY -->` leaves a block out. Commands of `make` are checked to exist; CI runs them.
"""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

from tests.support.readme_shell import ReadmeShell

README = Path(__file__).resolve().parents[2] / "README.md"
_BLOCK = re.compile(
    r"(?P<comments>(?:^<!--[^\n]*-->\n)*)^```(?P<language>\w*)\n(?P<text>.*?)^```$", re.M | re.S
)
_SHORT_FORM = re.compile(r"<!-- test: (.*) => (.*) -->")
_FILE = re.compile(r"<!-- file: (\S+) -->")


class Block(NamedTuple):
    """A fenced block of the README.

    Attributes:
        line: number of the line that opens it.
        kind: `python`, `shell`, `file`, `output` or `untested`.
        text: text to be run, in its short form, or the content of the file.
        name: name of the file, or empty.
    """

    line: int
    kind: str
    text: str
    name: str


def blocks(text: str) -> Iterator[Block]:
    """The blocks of a Markdown text; those without a language are commands if a command opens them."""
    for match in _BLOCK.finditer(text):
        content = match["text"]
        for long, short in _SHORT_FORM.findall(match["comments"]):
            if long not in content:
                raise ValueError(f"the block has no {long!r}:\n{content}")
            content = content.replace(long, short)
        file = _FILE.search(match["comments"])
        shell = re.match(r"(git|make|pip|prp-gym|source) ", content) is not None
        kind = "file" if file else match["language"] or ("shell" if shell else "output")
        kind = "untested" if "<!-- not tested: " in match["comments"] else kind
        yield Block(text.count("\n", 0, match.start("language")) + 1, kind, content, file[1] if file else "")


def run(text: str, folder: Path) -> list[str]:
    """Run the blocks of a Markdown text, and tell the kind of each."""
    shell = ReadmeShell(folder)
    kinds = []
    try:
        for block in blocks(text):
            kinds.append(block.kind)
            if block.kind == "python":
                shell.run_python(block.text)
            elif block.kind == "shell":
                shell.run(block.text)
            elif block.kind == "file":
                shell.write(block.name, block.text)
    finally:
        shell.close()
    return kinds


def test_every_block_runs_in_the_environment_that_the_readme_creates(tmp_path: Path) -> None:
    kinds = run(README.read_text(encoding="utf-8"), tmp_path)
    assert set(kinds) <= {"python", "shell", "file", "output", "untested"}
    assert kinds.count("python") >= 5
    assert kinds.count("shell") >= 4


INSTALL = "```\ngit clone X prp_gym\ncd prp_gym\nmake install\nsource .venv/bin/activate\n```\n"
NOT_ACTIVATED = INSTALL.replace("source .venv/bin/activate\n", "")


@pytest.mark.parametrize(
    ("text", "match"),
    [
        (
            NOT_ACTIVATED + "```\nprp-gym --version\n```\n",
            "prp-gym: command not",
        ),
        (INSTALL + "```python\nimport torch\n```\n", "extra agents is not installed"),
        (INSTALL + "```python\nprp_gym.evaluate()\n```\n", "name 'prp_gym' is not defined"),
        (INSTALL + "```\nprp-gym evaluate --env PRP-Nothing-v0\n```\n", "PRP-Nothing-v0"),
        (INSTALL + "```\nmake nothing\n```\n", "nothing"),
        ("```python\nimport prp_gym\n```\n", "prp_gym|no python"),
    ],
)
def test_what_the_readme_does_not_prepare_fails(text: str, match: str, tmp_path: Path) -> None:
    with pytest.raises(RuntimeError, match=match):
        run(text, tmp_path)


def test_short_form_that_matches_nothing_is_refused() -> None:
    with pytest.raises(ValueError, match="has no 'x'"):
        list(blocks("<!-- test: x => y -->\n```\nprp-gym list\n```\n"))
