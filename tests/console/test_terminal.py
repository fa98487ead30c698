"""Results on standard output, everything else on standard error."""

import json
import math

import pytest
from rich.table import Table

from prp_gym.console.lines import Lines
from prp_gym.console.silence import Silence
from prp_gym.console.terminal import Terminal


@pytest.fixture(autouse=True)
def no_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    """Variables that make rich take a pipe for a terminal, as some build servers set them."""
    for name in ("FORCE_COLOR", "TTY_COMPATIBLE", "COLUMNS"):
        monkeypatch.delenv(name, raising=False)


def write_all(terminal: Terminal) -> None:
    table = Table("header")
    table.add_row("cell")
    terminal.note("a note")
    terminal.warn("a warning")
    terminal.document({"value": math.nan, "unit": "µs"})
    terminal.show(table, "results: here")
    terminal.explain("an explanation [1]")


@pytest.mark.parametrize(
    ("terminal", "written", "told"),
    [
        (Terminal(), ("header", "cell", "results: here", "an explanation [1]"), ("a note", "a warning")),
        (Terminal(quiet=True), ("header", "cell", "results: here"), ("a warning",)),
        (Terminal(as_json=True), (), ("a note", "a warning")),
        (Terminal(quiet=True, as_json=True), (), ("a warning",)),
    ],
)
def test_results_and_notes_go_where_they_belong(
    terminal: Terminal, written: tuple[str, ...], told: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    write_all(terminal)
    output, errors = capsys.readouterr()
    assert errors.splitlines() == list(told)
    if terminal.as_json:
        assert json.loads(output) == {"value": None, "unit": "µs"}
    else:
        assert all(text in output for text in written)
        assert ("explanation" in output) is not terminal.quiet


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
    Terminal().show("word " * 100)
    assert 70 < max(map(len, capsys.readouterr().out.splitlines())) <= 80
