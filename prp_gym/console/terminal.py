"""`Terminal`: what a command writes to standard output and to standard error."""

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Self

from rich.console import Console

from prp_gym.artifacts import to_plain
from prp_gym.console.bars import Bars
from prp_gym.console.consoles import make_console
from prp_gym.console.legible import is_unicode, legible_table
from prp_gym.console.lines import Lines
from prp_gym.console.progress import Progress
from prp_gym.console.silence import Silence
from prp_gym.errors import InvalidValueError
from prp_gym.tables import ResultTable
from prp_gym.tables.formats import JSON, TERMINAL, write_tables
from prp_gym.tables.json_text import plain_tables
from prp_gym.tables.legible_text import legible

_SENTENCE = 0.5
"""Longest word of a line that is wrapped, in parts of the width."""


@dataclass(frozen=True)
class Terminal:
    """Results on standard output, everything else on standard error.

    Attributes:
        quiet: whether progress and notes are left out.
        form: form of the tables, one of `FORMATS`; with `JSON` all results are one JSON document.
    """

    quiet: bool = False
    form: str = TERMINAL
    _errors: Console = field(default_factory=lambda: make_console(stderr=True), repr=False, compare=False)

    @classmethod
    def of(cls, quiet: bool, as_json: bool, form: str = TERMINAL) -> Self:
        """The terminal that a command's options describe.

        Args:
            quiet: whether progress and notes are left out.
            as_json: whether the form is JSON.
            form: form of the tables, one of `FORMATS`.

        Raises:
            InvalidValueError: JSON and another form at the same time.
        """
        if as_json and form not in (TERMINAL, JSON):
            raise InvalidValueError("--format", form, "not beside --json, which is --format json")
        return cls(quiet, JSON if as_json else form)

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

    def report(
        self,
        content: Mapping[str, Any],
        tables: Sequence[ResultTable] = (),
        notes: Iterable[str] = (),
        lines: Iterable[str] = (),
    ) -> None:
        """Write the results to standard output.

        In a form for programs, notes and lines go to standard error, unless quiet.

        Args:
            content: all results, of any kind that `to_plain` takes, for the JSON document.
            tables: the results that people read.
            notes: what explains the tables, left out if quiet.
            lines: what belongs to the results, such as where they are; a long path is not broken.
        """
        if self.form == TERMINAL:
            console = make_console()
            for table in tables:
                console.print(table if is_unicode(console) else legible_table(table))
            for note in () if self.quiet else notes:
                _print(console, note)
            for line in lines:
                longest = max(map(len, line.split()), default=0)
                _print(console, line, wrapped=longest < _SENTENCE * console.width)
            return
        text = _document(content, tables) if self.form == JSON else write_tables(tables, self.form)
        print(text, end="")
        for line in [*notes, *lines]:
            self.note(line)


def _document(content: Mapping[str, Any], tables: Sequence[ResultTable]) -> str:
    """The results as one JSON document, with the tables under their own name."""
    plain = {**to_plain(content), **({"tables": plain_tables(tables)} if tables else {})}
    shown = json.dumps(plain, indent=2, ensure_ascii=not is_unicode(make_console()), allow_nan=False)
    return f"{shown}\n"


def _print(console: Console, text: str, wrapped: bool = True, style: str = "") -> None:
    shown = text if is_unicode(console) else legible(text)
    console.print(shown, markup=False, highlight=False, soft_wrap=not wrapped, style=style)
