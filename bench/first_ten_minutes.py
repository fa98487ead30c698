"""The first ten minutes with README: `make first-ten-minutes`.

The comment `<!-- first ten minutes -->` stands above the blocks of README with the commands that a newcomer
types in his first ten minutes. They are run one after the other from an empty folder, in a new clone of this
repository with a new virtual environment, and every command is timed. A command that serves a page is timed
until the page answers, and is then ended with Ctrl-C.
"""

import argparse
import json
import os
import re
import shlex
import signal
import subprocess
import sys
import tempfile
import time
import urllib.request
from dataclasses import dataclass
from pathlib import Path

from prp_gym.console.terminal import Terminal
from prp_gym.tables import Cell, ResultTable, TableColumn
from prp_gym.tables.column import text_column
from prp_gym.tables.formats import JSON, TERMINAL

ROOT = Path(__file__).resolve().parents[1]
MINUTES = 10.0
"""Time in which a newcomer should have seen it all [min]."""

_BLOCK = re.compile(r"^<!-- first ten minutes -->\n(?:<!--[^\n]*-->\n)*```\n(.*?)^```$", re.M | re.S)
_COMMENT = re.compile(r"\s+#\s.*$")
_ADDRESS = re.compile(r"http://\S+")
_PATIENCE = 60.0  # s, for a page
_KEPT = ("-c", "import json, os, sys; json.dump([dict(os.environ), os.getcwd()], open(sys.argv[1], 'w'))")


@dataclass(frozen=True)
class TimedCommand:
    """A command that was run.

    Attributes:
        command: the command as README has it.
        seconds: time that it took [s].
    """

    command: str
    seconds: float


class CommandError(RuntimeError):
    """A command of README that failed."""


def list_commands(text: str) -> list[str]:
    """The commands of the first ten minutes in a Markdown text, without comments.

    Args:
        text: content of README.
    """
    lines = (line for block in _BLOCK.findall(text) for line in block.splitlines())
    return [_COMMENT.sub("", line).strip() for line in lines if line.strip()]


class TimedShell:
    """Runs commands one after the other; each begins in the folder and environment that the last one left.

    Args:
        folder: empty folder in which the first command begins.
        state: file that holds the environment between two commands, outside the folder.
    """

    def __init__(self, folder: Path, state: Path) -> None:
        self._folder, self._state = folder, state
        self._environment = {name: value for name, value in os.environ.items() if name in ("PATH", "HOME")}

    def run(self, command: str) -> TimedCommand:
        """Run a command and time it.

        Raises:
            CommandError: it fails, or its page does not answer.
        """
        start = time.perf_counter()
        if shlex.split(command)[:2] == ["prp-gym", "view"]:
            self._open_page(command)
        else:
            self._run(command)
        return TimedCommand(command, time.perf_counter() - start)

    def _run(self, command: str) -> None:
        keep = shlex.join([sys.executable, *_KEPT, str(self._state)])
        done = self._start(f"set -e\n{command}\n{keep}\n")
        output, _ = done.communicate()
        if done.returncode:
            raise CommandError(f"{command}\nended with {done.returncode}:\n{output[-3000:]}")
        self._environment, folder = json.loads(self._state.read_text(encoding="utf-8"))
        self._folder = Path(folder)

    def _open_page(self, command: str) -> None:
        """Start a command that serves a page, read the page, and end it."""
        process = self._start(f"exec {command}")
        try:
            assert process.stdout is not None
            line = process.stdout.readline()
            found = _ADDRESS.search(line)
            if found is None:
                raise CommandError(f"{command}\nsays no address: {line}{process.stdout.read()[-3000:]}")
            with urllib.request.urlopen(found[0], timeout=_PATIENCE) as answer:
                if b"<html" not in answer.read().lower():
                    raise CommandError(f"{command}\n{found[0]} is no page")
        finally:
            process.send_signal(signal.SIGINT)
            try:
                process.communicate(timeout=_PATIENCE)
            except subprocess.TimeoutExpired:
                process.kill()
                process.communicate()
                raise CommandError(f"{command}\nran on for {_PATIENCE:g} s after Ctrl-C") from None

    def _start(self, script: str) -> "subprocess.Popen[str]":
        return subprocess.Popen(
            ["/bin/bash", "-c", script],
            env={**self._environment, "PYTHONUNBUFFERED": "1"},
            cwd=self._folder,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )


def run_readme(text: str, repository: str, terminal: Terminal) -> list[TimedCommand]:
    """Run the commands of the first ten minutes of a README from an empty folder.

    Args:
        text: content of README; `REPOSITORY` stands for the repository to clone.
        repository: address or path of the repository.
        terminal: terminal to which the commands are told.

    Raises:
        CommandError: a command that fails, or none that are to be run.
    """
    commands = list_commands(text)
    if not commands:
        raise CommandError("README has no block below a comment <!-- first ten minutes -->")
    done = []
    with tempfile.TemporaryDirectory() as folder:
        empty = Path(folder) / "empty"
        empty.mkdir()
        shell = TimedShell(empty, Path(folder) / "state.json")
        for command in commands:
            done.append(shell.run(command.replace("REPOSITORY", shlex.quote(repository))))
            terminal.note(f"{done[-1].seconds:6.1f} s  {command}")
    return done


def make_table(commands: list[TimedCommand]) -> ResultTable:
    """The times of the commands, and of all together."""
    columns = (text_column("command", 60), TableColumn("time", ("s",)), TableColumn("until then", ("min",)))
    rows, total = [], 0.0
    for item in commands:
        total += item.seconds
        rows.append((item.command, Cell.number(item.seconds, ".1f"), Cell.number(total / 60.0, ".2f")))
    return ResultTable.of("the first ten minutes", columns, rows)


def main() -> None:
    """Run README's commands and print their times; the exit code is 1 beyond ten minutes."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument("--repository", default=str(ROOT), help="repository to clone")
    parser.add_argument("--readme", type=Path, default=ROOT / "README.md", help="the README to follow")
    parser.add_argument("--json", action="store_true", help="write the times as JSON")
    options = parser.parse_args()
    terminal = Terminal(form=JSON if options.json else TERMINAL)
    try:
        done = run_readme(options.readme.read_text(encoding="utf-8"), options.repository, terminal)
    except CommandError as error:
        terminal.fail(str(error))
        sys.exit(1)
    total = sum(item.seconds for item in done)
    terminal.report({"seconds": total}, [make_table(done)])
    sys.exit(total > 60.0 * MINUTES)


if __name__ == "__main__":
    main()
