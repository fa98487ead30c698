"""Tables as Markdown, LaTeX, CSV, JSON and HTML, read back by parsers of these languages."""

import csv
import io
import json
import xml.etree.ElementTree as ElementTree

import pytest

from prp_gym.errors import UnknownNameError
from prp_gym.tables import ABSENT, Cell, ResultTable, TableColumn
from prp_gym.tables.column import interval_column, text_column
from prp_gym.tables.formats import FORMATS, write_tables
from tests.tables.test_result_table import TABLE

STRANGE = ResultTable.of(
    "100 % of <b>&_#$",
    (text_column('a|b "c"'), TableColumn("time", ("µs",)), interval_column("a~b^")),
    [('x, "y"\nz_{1} <i>', Cell.number(-1.5, ".1f"), Cell("0.1-0.2", (0.1, 0.2))), ("[x]", ABSENT, ABSENT)],
)


def test_names_of_the_forms() -> None:
    assert FORMATS == ("table", "md", "latex", "csv", "json")
    with pytest.raises(UnknownNameError, match="unknown format of tables 'xml'"):
        write_tables([TABLE], "xml")


def test_csv_is_read_back_with_exact_values_and_columns_for_parts() -> None:
    text = write_tables([TABLE], "csv")
    assert text.count("\r\n") == 3
    assert text.replace("\r\n", "").count("\n") == 0
    rows = list(csv.reader(io.StringIO(text, newline="")))
    assert rows == [
        [
            *("controller", "settling time [s]", "steady-state error 1 [mrad]", "steady-state error 2 [mm]"),
            *("95 % interval low", "95 % interval high"),
        ],
        ["joint_pd", "0.123456", "-12.34", "3.4", "0.5", "0.6"],
        ["hold", "", "inf", "", "", ""],
    ]


def test_csv_of_strange_texts_is_read_back_as_it_was() -> None:
    rows = list(csv.reader(io.StringIO(write_tables([STRANGE], "csv"), newline="")))
    assert rows[0][0] == 'a|b "c"'
    assert rows[1] == ['x, "y"\nz_{1} <i>', "-1.5", "0.1", "0.2"]


def test_json_has_every_table_with_titles_units_and_values() -> None:
    first, second = json.loads(write_tables([TABLE, STRANGE], "json"))
    assert first["title"] == "scores"
    assert first["columns"][2] == {
        "key": "steady_state_error",
        "title": "steady-state error",
        "units": ["mrad", "mm"],
        "parts": ["1", "2"],
    }
    assert first["rows"] == TABLE.records
    assert second["rows"][0]["time"] == -1.5


def test_markdown_has_as_many_cells_in_every_line() -> None:
    lines = write_tables([STRANGE], "md").splitlines()
    assert lines[0] == r"**100 % of \<b\>&_#$**"
    assert lines[3] == "| :--- | ---: | ---: |"
    assert {line.replace(r"\|", "").count("|") for line in lines[2:]} == {4}
    assert lines[4] == r'| x, "y" z_{1} \<i\> | -1.5 | 0.1-0.2 |'


def test_latex_has_rules_and_escapes_every_special_character() -> None:
    lines = write_tables([STRANGE], "latex").splitlines()
    assert lines[2] == r"\caption{100 \% of \textless{}b\textgreater{}\&\_\#\$}"
    assert lines[3] == r"\begin{tabular}{lrr}"
    rules = [line for line in lines if line.endswith("rule")]
    assert rules == [r"\toprule", r"\midrule", r"\bottomrule"]
    assert (
        r"a\textbar{}b \textquotedbl{}c\textquotedbl{} & time [\textmu{}s] & a\textasciitilde{}b" in lines[5]
    )
    assert lines[7] == (
        r"x, \textquotedbl{}y\textquotedbl{} z\_\{1\} \textless{}i\textgreater{} & $-$1.5 & 0.1--0.2 \\"
    )
    assert lines[8] == r"{}[x] & -- & -- \\"  # a bracket after \\ would be its argument


def test_html_is_well_formed_and_escaped() -> None:
    root = ElementTree.fromstring(STRANGE._repr_html_())
    assert root.findtext("caption") == "100 % of <b>&_#$"
    assert [cell.text for cell in root.iter("th")] == ['a|b "c"', "time [µs]", "a~b^"]
    assert next(root.iter("td")).text == 'x, "y"\nz_{1} <i>'


def test_several_tables_stand_apart() -> None:
    assert write_tables([TABLE, TABLE], "csv").split("\r\n\r\n")[1].startswith("controller,")
    assert write_tables([TABLE, TABLE], "md").count("**scores**") == 2
