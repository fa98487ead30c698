"""Results on standard output, everything else on standard error."""

import json
import math

import pytest

from prp_gym.console.lines import Lines
from prp_gym.console.silence import Silence
from prp_gym.console.terminal import Terminal
from prp_gym.errors import InvalidValueError
from prp_gym.tables import Cell, ResultTable, TableColumn
from prp_gym.tables.column import text_column


@pytest.fixture(autouse=True)
def no_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    """Variables that make rich take a pipe for a terminal, as some build servers set them."""
    for name in ("FORCE_COLOR", "TTY_COMPATIBLE", "COLUMNS"):
        monkeypatch.delenv(name, raising=False)


TABLE = ResultTable.of(
    "numbers", (text_column("header"), TableColumn("time", ("µs",))), [("cell", Cell.number(1.0))]
)


def write_all(terminal: Terminal) -> None:
    terminal.note("a note")
    terminal.warn("a warning")
    terminal.report({"value": math.nan, "unit": "µs"}, [TABLE], ["an explanation [1]"], ["results: here"])


@pytest.mark.parametrize(
    ("terminal", "written", "told"),
    [
        (Terminal(), ("numbers", "cell", "an explanation [1]", "results: here"), ("a note", "a warning")),
        (Terminal(quiet=True), ("numbers", "cell", "results: here"), ("a warning",)),
        (
            Terminal(form="md"),
            ("**numbers**", "| cell | 1.000 |"),
            ("a note", "a warning", "an explanation [1]", "results: here"),
        ),
        (Terminal(form="csv", quiet=True), ("header,time [µs]", "cell,1.0"), ("a warning",)),
    ],
)
def test_results_and_notes_go_where_they_belong(
    terminal: Terminal, written: tuple[str, ...], told: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    write_all(terminal)
    output, errors = capsys.readouterr()
    assert errors.splitlines() == list(told)
    assert all(text in output for text in written)
    assert ("explanation" in output) is ("an explanation [1]" in written)


@pytest.mark.parametrize("quiet", [False, True])
def test_json_is_one_document_with_the_results_and_their_tables(
    quiet: bool, capsys: pytest.CaptureFixture[str]
) -> None:
    write_all(Terminal.of(quiet, as_json=True))
    output, errors = capsys.readouterr()
    found = json.loads(output)
    assert (found["value"], found["unit"]) == (None, "µs")
    assert [table["rows"] for table in found["tables"]] == [TABLE.records]
    assert ("results: here" in errors) is not quiet


def test_json_and_another_form_are_refused() -> None:
    assert Terminal.of(False, True, "json") == Terminal(form="json")
    with pytest.raises(InvalidValueError, match="--format is 'csv'; allowed: not beside --json"):
        Terminal.of(quiet=False, as_json=True, form="csv")


def test_progress_without_a_terminal_is_lines_and_nothing_if_quiet() -> None:
    assert isinstance(Terminal().progress("working"), Lines)
    assert isinstance(Terminal(quiet=True).progress("working"), Silence)


def test_message_in_a_pipe_is_one_line_however_long(capsys: pytest.CaptureFixture[str]) -> None:
    Terminal().fail("error: " + "word " * 100)
    assert len(capsys.readouterr().err.splitlines()) == 1


def test_width_without_a_terminal_is_that_of_columns(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    Terminal().report({}, lines=["word " * 100])
    assert 70 < max(map(len, capsys.readouterr().out.splitlines())) <= 80
