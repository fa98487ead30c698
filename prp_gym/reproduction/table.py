"""Verdicts and answers as tables for the terminal."""

from collections.abc import Sequence

from rich.box import SIMPLE_HEAD
from rich.table import Table

from prp_gym.reproduction.experiment import Answer
from prp_gym.reproduction.outcome import FigureOutcome, show, unit_of

_STYLES = {"pass": "green", "explained": "yellow", "FAIL": "bold red"}


def _table(title: str) -> Table:
    return Table(title=title, title_justify="left", box=SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))


def verdict_table(outcomes: Sequence[FigureOutcome]) -> Table:
    """Every check of some figures."""
    table = _table("predicted and measured")
    for header in ("figure", "question"):
        table.add_column(header, justify="right", no_wrap=True)
    for header, width in (("quantity", 30), ("predicted", 21), ("measured", 20), ("tolerance", 11)):
        table.add_column(header, max_width=width, overflow="fold")
    table.add_column("verdict", no_wrap=True)
    for outcome in outcomes:
        for index, verdict in enumerate(outcome.verdicts):
            check = verdict.check
            table.add_row(
                "" if index else str(outcome.experiment.number),
                check.question,
                f"{check.what} \\[{unit_of(check)}]",
                show(verdict.predicted),
                show(verdict.measured),
                show(verdict.tolerance, digits=2),
                f"[{_STYLES[verdict.word]}]{verdict.word}[/]",
            )
    return table


def answers_table(answers: Sequence[tuple[Answer, str]]) -> Table:
    """The report's questions with their answers."""
    table = _table("answers")
    table.add_column("question", justify="right")
    table.add_column("answer", overflow="fold")
    for answer, text in answers:
        table.add_row(answer.question, f"{answer.asks}\n{text}".replace("[", "\\["))
    return table
