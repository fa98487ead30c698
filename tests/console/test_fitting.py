"""Tables that are too wide are split between their columns, and no cell is cut."""

import io

import pytest
from rich.box import HEAVY_HEAD, SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from prp_gym.console.fitting import fit
from prp_gym.console.legible import legible_table


def wide(columns: int, box: object = SIMPLE_HEAD, gap: int = 1) -> Table:
    table = Table(title="numbers", title_justify="left", box=box, pad_edge=False, padding=(0, gap, 0, 0))  # type: ignore[arg-type]
    table.add_column("name", no_wrap=True)
    for number in range(columns):
        table.add_column(f"column\nof {number}", justify="right", no_wrap=True)
    for row in range(3):
        table.add_row(f"policy_{row}", *(f"{row}.{number:02d}0 [x]" for number in range(columns)))
    return table


def printed(tables: list[Table], width: int) -> list[str]:
    stream = io.StringIO()
    console = Console(file=stream, width=width, color_system=None)
    for table in tables:
        console.print(table)
    return stream.getvalue().splitlines()


@pytest.mark.parametrize("box", [SIMPLE_HEAD, HEAVY_HEAD, None])
@pytest.mark.parametrize("width", [40, 79, 80, 120])
@pytest.mark.parametrize("columns", [1, 5, 8, 9, 30])
@pytest.mark.parametrize("gap", [0, 1, 2])
def test_no_cell_is_cut_and_no_line_is_too_long(box: object, width: int, columns: int, gap: int) -> None:
    parts = fit(wide(columns, box, gap), Console(width=width))
    lines = printed(parts, width)
    assert max(map(len, lines)) <= width
    text = "\n".join(lines)
    assert "…" not in text
    assert all(f"{row}.{number:02d}0" in text for row in range(3) for number in range(columns))
    assert sum("policy_1" in line for line in lines) == len(parts)


def test_table_that_fits_is_one_table_and_a_column_more_splits_it() -> None:
    for columns in range(2, 14, 3):
        natural = max(map(len, printed([wide(columns)], 1000)))
        assert [len(fit(wide(columns), Console(width=width))) for width in (natural, natural - 1)] == [1, 2]


def test_later_parts_say_that_they_go_on() -> None:
    titles = [table.title for table in fit(wide(12), Console(width=60))]
    assert titles[0] == "numbers"
    assert set(titles[1:]) == {"numbers (continued)"}


def test_wrapped_text_gets_narrower_before_a_table_is_split() -> None:
    table = Table(box=SIMPLE_HEAD)
    table.add_column("name", no_wrap=True)
    table.add_column("text", overflow="fold")
    table.add_row("one", "many words " * 30)
    assert fit(table, Console(width=60)) == [table]


def test_column_needs_no_more_than_its_largest_width() -> None:
    table = Table(box=SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))
    for name in ("first", "second", "third"):
        table.add_column(name, max_width=16, overflow="fold")
    table.add_row(*["some words that wrap"] * 3)
    assert len(fit(table, Console(width=60))) == 1
    assert max(map(len, printed([table], 60))) <= 60


def test_table_in_ascii_has_legible_cells_and_lines() -> None:
    table = Table(title="γ and ẋ", box=SIMPLE_HEAD)
    table.add_column("stiffness\nN·m/rad²")
    table.add_row("1 → ∞ µs")
    lines = printed([legible_table(table)], 80)
    assert all(line.isascii() for line in lines)
    assert "gamma and x_dot" in "\n".join(lines)
    assert "N m/rad^2" in "\n".join(lines)
    assert "1 -> inf us" in "\n".join(lines)
