"""Texts on terminals that show ASCII alone."""

import io
import re
import subprocess
from pathlib import Path

import pytest
from rich.console import Console

from prp_gym.console.legible import legible_table
from prp_gym.tables import Cell, ResultTable, TableColumn
from prp_gym.tables.legible_text import legible

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("compute time µs", "compute time us"),
        ("m/s², N·m", "m/s^2, N m"),
        ("ẋ, q̈ and ḋ", "x_dot, q_ddot and d_dot"),
        ("correlation γ, Σ, Δ", "correlation gamma, sum, Delta"),
        ("± 1 ≤ 2 → 3 × 4 … ∞", "+/- 1 <= 2 -> 3 x 4 ... inf"),
        ("Müller", "Muller"),
        ("plain", "plain"),
    ],
)
def test_characters_beyond_ascii_have_legible_replacements(text: str, expected: str) -> None:
    assert legible(text) == expected


def test_table_in_ascii_has_legible_texts_lines_and_the_same_values() -> None:
    columns = (TableColumn("stiff\u00adness Σ", ("N·m/rad²",)), TableColumn("µ"))
    table = legible_table(ResultTable.of("γ and ẋ", columns, [(Cell("1 → ∞ µs", 1.0), Cell("½", "½"))]))
    assert table.columns[0].heading == "stiff\u00adness sum"
    assert table.rows[0][1].value == "½"
    stream = io.TextIOWrapper(io.BytesIO(), encoding="ascii")
    Console(file=stream, width=80, color_system=None).print(table)
    stream.seek(0)
    lines = [line.rstrip() for line in stream.read().splitlines() if line.strip()]
    assert all(line.isascii() for line in lines)
    assert lines[0] == "gamma and x_dot"
    assert " ".join(" ".join(lines[1:-2]).split()) == "stiffness sum N m/rad^2 u"
    assert lines[-1].split() == ["1", "->", "inf", "us", "1/2"]


def test_every_character_of_the_texts_that_commands_print_has_one() -> None:
    listed = subprocess.run(
        ["git", "ls-files", "*.py", "*.toml", "*.yml"], cwd=ROOT, capture_output=True, text=True, check=True
    )
    names = [name for name in listed.stdout.split() if not name.startswith(("tests/", "bench/", "docs/"))]
    text = "".join((ROOT / name).read_text(encoding="utf-8") for name in names if (ROOT / name).is_file())
    letters = {letter for letter in text if not letter.isascii()}
    assert len(letters) > 20
    assert {letter for letter in letters if not re.fullmatch(r"[ -~]*", legible(letter))} == set()
    assert {letter for letter in letters if "?" in legible(letter)} == set()
