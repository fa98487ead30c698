"""`Terminal`: what a command writes to standard output and to standard error."""

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from rich.console import Console
from rich.table import Table

from prp_gym.artifacts import to_plain
from prp_gym.console.bars import Bars
from prp_gym.console.consoles import make_console
from prp_gym.console.fitting import fit
from prp_gym.console.legible import is_unicode, legible, legible_table
from prp_gym.console.lines import Lines
from prp_gym.console.progress import Progress
from prp_gym.console.silence import Silence


@dataclass(frozen=True)
class Terminal:
    """Results on standard output, everything else on standard error.

    Attributes:
        quiet: whether progress and notes are left out.
        as_json: whether the results are one JSON document in place of tables.
    """

    quiet: bool = False
    as_json: bool = False
    _errors: Console = field(default_factory=lambda: make_console(stderr=True), repr=False, compare=False)

    def progress(self, label: str, total: float = math.inf, unit: str = "", done: float = 0.0) -> Progress:
        """How far some work is: bars in a terminal, a line now and then elsewhere, nothing if quiet.

        Args:
            label: what is done, such as "evaluating".
            total: amount of work in `unit`; infinite if it is not known.
            unit: unit of the amount, such as "episodes".
            done: amount that an interrupted run has done before.
        """
        if self.quiet:
            return Silence()
        if self._errors.is_terminal and not self._errors.is_dumb_terminal:
            return Bars(self._errors, label, total, done)
        return Lines(self.note, label, total, unit, done)

    def note(self, text: str) -> None:
        """Write a line about the work to standard error, unless quiet.

        Args:
            text: the line.
        """
        if not self.quiet:
            self.warn(text)

    def warn(self, text: str) -> None:
        """Write a line to standard error, also if quiet.

        Args:
            text: the line.
        """
        _print(self._errors, text, wrapped=self._errors.is_terminal)

    def fail(self, text: str) -> None:
        """Write the message of an error to standard error, in red in a terminal.

        Args:
            text: the message.
        """
        _print(self._errors, text, wrapped=self._errors.is_terminal, style="red")

    def show(self, *results: Table | str) -> None:
        """Write results to standard output, tables in as many parts as the width needs; not with `as_json`.

        Args:
            results: tables, and lines of text.
        """
        if self.as_json:
            return
        console = make_console()
        for result in results:
            if isinstance(result, str):
                _print(console, result)
                continue
            table = result if is_unicode(console) else legible_table(result)
            for part in fit(table, console):
                console.print(part)

    def explain(self, *notes: str) -> None:
        """Write notes on the results below them, unless quiet or with `as_json`.

        Args:
            notes: lines of text.
        """
        if not self.quiet:
            self.show(*notes)

    def document(self, content: Mapping[str, Any]) -> None:
        """Write the results as one JSON document to standard output, with `as_json` alone.

        Args:
            content: value of any kind that `to_plain` takes.
        """
        if self.as_json:
            console = make_console()
            plain = to_plain(content)
            print(json.dumps(plain, indent=2, ensure_ascii=not is_unicode(console), allow_nan=False))


def _print(console: Console, text: str, wrapped: bool = True, style: str = "") -> None:
    shown = text if is_unicode(console) else legible(text)
    console.print(shown, markup=False, highlight=False, soft_wrap=not wrapped, style=style)
