"""The page of errata: every entry is complete and backed by tests that exist."""

import ast
import re
from pathlib import Path

import pytest

FOLDER = Path(__file__).resolve().parent
PAGE = (FOLDER.parents[1] / "docs" / "errata.md").read_text(encoding="utf-8")
PARTS = ("Where.", "Printed", "Right.", "Why.", "Consequence.", "Test.")
LAST = 33


def sections() -> dict[int, str]:
    """Text of every entry by its number."""
    pieces = re.split(r"^## E(\d+) ", PAGE, flags=re.MULTILINE)[1:]
    return {int(number): text for number, text in zip(pieces[::2], pieces[1::2], strict=True)}


def named_tests(text: str) -> set[tuple[str, str]]:
    """File and function of every test that a text names."""
    return set(re.findall(r"`tests/errata/(test_\w+\.py)::(test_\w+)`", text))


def written_tests() -> set[tuple[str, str]]:
    """File and function of every test in the files on errata, this one excepted."""
    return {
        (path.name, node.name)
        for path in FOLDER.glob("test_*.py")
        if path.name != Path(__file__).name
        for node in ast.parse(path.read_text(encoding="utf-8")).body
        if isinstance(node, ast.FunctionDef) and node.name.startswith("test_")
    }


def test_entries_are_numbered_without_gaps() -> None:
    numbers = [int(number) for number in re.findall(r"^## E(\d+) ", PAGE, flags=re.MULTILINE)]
    assert numbers == list(range(1, LAST + 1))


@pytest.mark.parametrize("number", range(1, LAST + 1))
def test_entry_says_what_is_printed_what_is_right_and_which_test_shows_it(number: int) -> None:
    text = sections()[number]
    positions = [text.find(f"- **{part}") for part in PARTS]
    assert -1 not in positions
    assert positions == sorted(positions)
    tests = named_tests(text)
    assert tests
    assert tests <= written_tests()


def test_every_test_of_an_erratum_is_named_by_one_entry() -> None:
    named = [test for text in sections().values() for test in named_tests(text)]
    assert sorted(named) == sorted(written_tests())


def test_entries_that_the_text_refers_to_exist() -> None:
    assert {int(number) for number in re.findall(r"\bE(\d+)\b", PAGE)} <= set(range(1, LAST + 1))
