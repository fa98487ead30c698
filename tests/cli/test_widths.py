"""What commands print fits the terminal, also one of 80 columns and one that shows ASCII alone."""

import os
import re
import subprocess
import sys
from functools import partial
from pathlib import Path

import gymnasium
import pytest
from rich.cells import cell_len
from typer.testing import CliRunner

from prp_gym.cli.main import COMMANDS, app

SMALL = {
    "list": (),
    "matrix": ("list", "--matrix"),
    "modes": ("list", "--modes"),
    "algorithms": ("list", "--algorithms"),
    "metrics": ("list", "--metrics"),
    "evaluate": (
        *("evaluate", "-e", "PRP-ForcePosition-v0", "-e", "PRP-Adaptive-v0", "-s", "realistic", "-n", "2"),
        *("-j", "1"),
    ),
    "compare": (
        *("compare", "-e", "PRP-JointTracking-v0", "-s", "randomized", "-n", "2", "-j", "1"),
        *("-b", "joint_pd", "-b", "operational_inverse_dynamics"),
    ),
    "audit": ("audit", "-e", "PRP-Adaptive-v0", "-n", "2", "--draws", "1", "-j", "1"),
    "tune": ("tune", "joint_pd", "-e", "PRP-Adaptive-v0", "--budget", "100", "-n", "2"),
    "tune-all": ("tune-all", "-b", "adaptive", "-e", "PRP-Adaptive-v0", "--budget", "1000", "-j", "1"),
    "reproduce": ("reproduce", "--figure", "12"),
}


@pytest.fixture
def short_episodes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(gymnasium, "make", partial(gymnasium.make, duration=0.05))


@pytest.mark.parametrize("name", SMALL)
def test_command_prints_no_line_wider_than_80_columns_and_cuts_no_cell(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest
) -> None:
    if name != "reproduce":
        request.getfixturevalue("short_episodes")
    request.getfixturevalue("unwritten_figures")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")
    for variable in ("FORCE_COLOR", "TTY_COMPATIBLE"):
        monkeypatch.delenv(variable, raising=False)
    result = CliRunner().invoke(app, SMALL[name] or ("list",))
    assert result.exit_code in (0, 1), result.output
    assert max(map(cell_len, result.stdout.splitlines())) <= 80
    assert "…" not in result.stdout
    headers = [line for line in result.stdout.splitlines() if set(line.strip()) == {"─"}]
    assert headers or "━" in result.stdout  # there are tables


@pytest.mark.parametrize("command", ["", *COMMANDS])
def test_help_fits_80_columns(command: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("TERMINAL_WIDTH", "80")
    result = CliRunner().invoke(app, [*([command] if command else []), "--help"])
    text = re.sub(r"\x1b\[[0-9;]*m", "", result.output)
    assert max(map(len, text.splitlines())) <= 80
    assert "…" not in text


ASCII = {
    "PYTHONIOENCODING": "ascii",
    "LANG": "C",
    "LC_ALL": "C",
    "PYTHONUTF8": "0",
    "PYTHONCOERCECLOCALE": "0",
}


@pytest.mark.parametrize(
    "command",
    [
        ("list", "--metrics"),
        (
            *("evaluate", "-e", "PRP-Adaptive-v0", "-b", "joint_pd", "-s", "report", "-j", "1"),
            *("--control-frequency", "50", "--gains", "tuned_50hz"),
        ),
        ("evaluate", "--help"),
    ],
    ids=["list", "evaluate", "help"],
)
def test_terminal_that_shows_ascii_alone_gets_legible_text(tmp_path: Path, command: tuple[str, ...]) -> None:
    plain = {name: value for name, value in os.environ.items() if name not in ("FORCE_COLOR", "COLUMNS")}
    done = subprocess.run(
        [sys.executable, "-m", "prp_gym.cli.main", *command],
        cwd=tmp_path,
        env={**plain, **ASCII, "COLUMNS": "80"},
        capture_output=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    text = done.stdout.decode("ascii")
    assert "Traceback" not in done.stderr.decode("ascii")
    assert "?" not in text
    assert max(map(len, text.splitlines())) <= 80
    if command[0] == "evaluate" and "--help" not in command:
        assert "time" in text
        assert re.search(r"\bus\b", text)  # of the compute time
