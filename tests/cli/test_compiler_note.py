"""One line of a command says that NumPy stands in for compiled code that the machine lacks."""

from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from prp_gym.cli import compiler_note
from prp_gym.cli.main import app
from prp_gym.console.terminal import Terminal
from prp_gym.errors import CompilerError

REASON = "there is none."


def find_none() -> None:
    raise CompilerError(REASON)


def lines(capsys: pytest.CaptureFixture[str], terminal: Terminal) -> list[str]:
    compiler_note.note_missing_compiler(terminal)
    out, err = capsys.readouterr()
    assert out == ""
    return err.splitlines()


def test_missing_compiler_is_said_in_one_line(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("PRP_GYM_COMPILED", raising=False)
    monkeypatch.setattr(compiler_note, "require_compiled_code", find_none)
    (line,) = lines(capsys, Terminal())
    assert line.startswith(f"{REASON} NumPy computes the same results")
    assert lines(capsys, Terminal(quiet=True)) == []
    monkeypatch.setenv("PRP_GYM_COMPILED", "0")
    assert lines(capsys, Terminal()) == []


def test_compiled_code_is_not_mentioned(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(compiler_note, "require_compiled_code", lambda: None)
    assert lines(capsys, Terminal()) == []


@pytest.mark.parametrize("command", ["evaluate", "compare", "tune", "tune-all", "train", "audit"])
def test_every_command_that_simulates_much_has_the_line(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Before it has begun with anything."""

    class _SaidError(Exception):
        pass

    def say(terminal: Terminal, *_: Any) -> None:
        raise _SaidError

    module = command.replace("-", "_")
    monkeypatch.setattr(f"prp_gym.cli.{module}.note_missing_compiler", say)
    given = {
        "tune": ["joint_pd", "--env", "PRP-JointTracking-v0", "--budget", "5000"],
        "train": ["PRP-JointTracking-v0"],
    }
    arguments = [command, *given.get(command, []), "--output", str(tmp_path / "out")]
    result = CliRunner().invoke(app, arguments)
    assert isinstance(result.exception, _SaidError), result.output
    assert not (tmp_path / "out").exists()
