"""README's commands of the first ten minutes: found, run from an empty folder, timed."""

import sys
from pathlib import Path

import pytest
import typer

from bench.first_ten_minutes import (
    CommandError,
    TimedCommand,
    TimedShell,
    list_commands,
    make_table,
    run_readme,
)
from prp_gym.cli.main import app
from prp_gym.console.terminal import Terminal

README = Path(__file__).resolve().parents[2] / "README.md"
COMMENT = "<!-- first ten minutes -->\n"
PAGE = """#!{python}
import http.server, sys
sys.argv[1:2] == ["view"] or sys.exit(2)
class Page(http.server.BaseHTTPRequestHandler):
    def do_GET(self):
        self.send_response(200)
        self.end_headers()
        self.wfile.write(b"<html></html>")
server = http.server.HTTPServer(("127.0.0.1", 0), Page)
print("http://127.0.0.1:%d shows it. Ctrl-C ends." % server.server_port, flush=True)
try:
    server.serve_forever()
except KeyboardInterrupt:
    sys.exit(130)
"""


def test_readme_has_every_step_of_the_first_ten_minutes() -> None:
    commands = list_commands(README.read_text(encoding="utf-8"))
    assert commands[:4] == [
        "git clone REPOSITORY prp_gym",
        "cd prp_gym",
        "make install",
        "source .venv/bin/activate",
    ]
    used = {command.split()[1] for command in commands if command.startswith("prp-gym ")}
    assert {"record", "view", "evaluate", "plot"} <= used
    assert used <= set(typer.main.get_command(app).commands)  # type: ignore[attr-defined]


def test_commands_run_where_the_last_one_ended(tmp_path: Path) -> None:
    (tmp_path / "mine").write_text("content", encoding="utf-8")
    text = (
        "```\nfalse\n```\n\n"
        f"{COMMENT}<!-- test: a => b -->\n```\nmkdir made    # a comment\ncd made\nexport FIRST=1\n```\n\n"
        f"{COMMENT}```\ntest $FIRST = 1\ntest $(basename $PWD) = made\ncat REPOSITORY/mine > here\n```\n"
    )
    done = run_readme(text, str(tmp_path), Terminal(quiet=True))
    assert [item.command for item in done][:2] == ["mkdir made", "cd made"]
    assert len(done) == 6
    assert all(item.seconds > 0.0 for item in done)


def test_command_that_fails_is_named_with_what_it_printed() -> None:
    with pytest.raises(CommandError, match=r"(?s)echo told; false\nended with 1:\ntold"):
        run_readme(f"{COMMENT}```\necho told; false\n```\n", "", Terminal(quiet=True))
    with pytest.raises(CommandError, match="has no block"):
        run_readme("```\ntrue\n```\n", "", Terminal(quiet=True))


def test_page_is_timed_until_it_answers_and_ended(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    command = tmp_path / "prp-gym"
    command.write_text(PAGE.format(python=sys.executable), encoding="utf-8")
    command.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:/usr/bin:/bin")
    shell = TimedShell(tmp_path, tmp_path / "state.json")
    assert shell.run("prp-gym view PRP-Force-v0 --web").seconds > 0.0
    command.write_text("#!/bin/sh\necho no display\n", encoding="utf-8")
    with pytest.raises(CommandError, match="says no address: no display"):
        shell.run("prp-gym view PRP-Force-v0")


def test_table_adds_the_times_up() -> None:
    table = make_table([TimedCommand("make install", 90.0), TimedCommand("prp-gym list", 30.0)])
    assert [row[2].value for row in table.rows] == [1.5, 2.0]
