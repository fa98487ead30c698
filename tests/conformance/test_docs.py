"""The committed pages are what the declarations say."""

from pathlib import Path

import pytest

from docs.generate import FOLDER, PAGES

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.parametrize("name", PAGES)
def test_generated_page_is_up_to_date(name: str) -> None:
    assert (FOLDER / name).read_text(encoding="utf-8") == PAGES[name](), "run `make docs`"


def test_readme_starts_with_installation_and_commands() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    blocks = text.split("```")[1:4:2]
    assert [line.split("#")[0].strip() for block in blocks for line in block.splitlines()[1:] if line] == [
        "git clone REPOSITORY prp_gym",
        "cd prp_gym",
        "make install",
        "source .venv/bin/activate",
        "make evaluate",
        "make test",
        "make reproduce",
        "make compare",
    ]


def test_source_keys_of_docstrings_are_resolved() -> None:
    references = (FOLDER / "references.md").read_text(encoding="utf-8")
    for key in ("[R]", "[S]", "[G]", "[M]", "ISO 9283"):
        assert f"| {key} |" in references
