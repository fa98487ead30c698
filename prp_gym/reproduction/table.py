"""Verdicts and answers as tables for the terminal."""

from collections.abc import Sequence

from rich.box import SIMPLE_HEAD
from rich.table import Table

from prp_gym.reproduction.experiment import Answer
from prp_gym.reproduction.outcome import FigureOutcome, show

_STYLES = {"pass": "green", "explained": "yellow", "FAIL": "bold red"}


def verdict_table(outcomes: Sequence[FigureOutcome]) -> Table:
    """Every check of some figures."""
    table = Table(title="predicted and measured", title_justify="left", box=SIMPLE_HEAD, pad_edge=False)
    for header in ("figure", "question"):
        table.add_column(header, justify="right")
    for header in ("what", "predicted", "measured", "tolerance"):
        table.add_column(header, overflow="fold")
    table.add_column("verdict")
    for outcome in outcomes:
        for index, verdict in enumerate(outcome.verdicts):
            check = verdict.check
            table.add_row(
                "" if index else str(outcome.experiment.number),
                check.question,
                f"{check.what} \\[{', '.join(check.unit)}]",
                show(verdict.predicted),
                show(verdict.measured),
                show(verdict.tolerance),
                f"[{_STYLES[verdict.word]}]{verdict.word}[/]",
            )
    return table


def answers_table(answers: Sequence[tuple[Answer, str]]) -> Table:
    """The report's questions with their answers."""
    table = Table(title="answers", title_justify="left", box=SIMPLE_HEAD, pad_edge=False)
    table.add_column("question", justify="right")
    table.add_column("answer", overflow="fold")
    for answer, text in answers:
        table.add_row(answer.question, f"{answer.asks}\n{text}".replace("[", "\\["))
    return table
