"""A table as a value: what it refuses, and how a terminal shows it."""

import io
import math

import pytest
from rich.console import Console

from prp_gym.errors import InvalidValueError, ShapeError
from prp_gym.tables import ABSENT, Cell, ResultTable, TableColumn
from prp_gym.tables.column import interval_column, prose_column, text_column

TABLE = ResultTable.of(
    "scores",
    (
        text_column("controller"),
        TableColumn("set\u00adtling time", ("s",)),
        TableColumn("steady-state error", ("mrad", "mm"), parts=("1", "2")),
        interval_column(),
    ),
    [
        ("joint_pd", Cell.number(0.123456), Cell("-12 3.4", (-12.34, 3.4)), Cell("0.5-0.6", (0.5, 0.6))),
        ("hold", ABSENT, Cell("never", (math.inf, math.nan)), ABSENT),
    ],
)


def shown(table: ResultTable, width: int = 120) -> list[str]:
    target = io.StringIO()
    Console(file=target, width=width, color_system=None).print(table)
    return target.getvalue().splitlines()


def test_two_columns_with_one_heading_are_refused() -> None:
    columns = (text_column("name"), TableColumn("peak\u00ad force"), TableColumn("peak force"))
    with pytest.raises(InvalidValueError, match="'peak force'; allowed: each heading once"):
        ResultTable.of("t", columns, [])


def test_columns_that_differ_in_their_unit_have_different_keys() -> None:
    columns = (TableColumn("force", ("N",)), TableColumn("force", ("%",)), TableColumn("f: x"))
    assert ResultTable.of("t", columns, []).keys == ["force", "force_2", "f_x"]


def test_row_of_another_length_is_refused() -> None:
    with pytest.raises(ShapeError, match=r"row of table 't' has shape \(1,\); expected \(2,\)"):
        ResultTable.of("t", (text_column("a"), text_column("b")), [("x",)])


def test_values_are_exact_and_strict_json() -> None:
    assert TABLE.records[0]["settling_time"] == 0.123456
    assert TABLE.records[0]["95_percent_interval"] == [0.5, 0.6]
    assert TABLE.records[1]["steady_state_error"] == ["inf", None]
    assert TABLE.records[1]["settling_time"] is None


def test_terminal_shows_title_folded_headings_units_and_cells() -> None:
    lines = shown(TABLE)
    assert lines[0].strip() == "scores"
    rule = next(index for index, line in enumerate(lines) if "───" in line)
    assert lines[rule - 1].split() == ["controller", "s", "mrad", "mm", "interval"]
    assert " ".join(" ".join(lines[1:rule]).split()).startswith("set- steady- tling state")
    assert lines[rule + 1].split() == ["joint_pd", "0.123", "-12", "3.4", "0.5-0.6"]


def test_narrow_terminal_gets_several_parts_that_repeat_the_names() -> None:
    lines = shown(TABLE, 30)
    assert max(len(line.rstrip()) for line in lines) <= 30
    assert [line.split() for line in lines if line.strip().startswith("joint_pd")] == [
        ["joint_pd", "0.123", "-12", "3.4"],
        ["joint_pd", "0.5-0.6"],
    ]
    titles = [line.strip() for line in lines if line.startswith(TABLE.title[:10])]
    assert titles == [TABLE.title, f"{TABLE.title} (continued)"]


@pytest.mark.parametrize("width", range(30, 100, 3))
def test_nothing_is_cut_off_at_any_width(width: int) -> None:
    columns = (text_column("name"), *(TableColumn(f"column_of_{index}") for index in range(8)))
    table = ResultTable.of("t", columns, [("operational", *(f"{index}" * 11 for index in range(8)))])
    text = " ".join(shown(table, width))
    assert "…" not in text
    assert all(f"{index}" * 11 in text.split() for index in range(8))
    assert text.count("operational") == len([line for line in shown(table, width) if "───" in line])


def test_long_name_is_broken_at_its_width_and_whole_elsewhere() -> None:
    table = ResultTable.of("t", (text_column("name", 10), TableColumn("n")), [("residual_joint_pd", "1")])
    assert [line.split() for line in shown(table)[-3:-1]] == [["residual_"], ["joint_pd", "1"]]
    assert table.records == [{"name": "residual_joint_pd", "n": "1"}]


def test_sentences_wrap_into_the_width() -> None:
    table = ResultTable.of("t", (text_column("name"), prose_column("what")), [("a", "word " * 30)])
    lines = shown(table, 40)
    assert max(map(len, lines)) <= 40
    assert " ".join(lines).count("word") == 30


def test_text_with_markup_is_shown_as_it_is() -> None:
    table = ResultTable.of("[bold]t[/]", (text_column("a"),), [("[red]x[/red]",)])
    assert shown(table)[0] == "[bold]t[/]"
    assert any("[red]x[/red]" in line for line in shown(table))
