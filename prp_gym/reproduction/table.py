"""Verdicts and answers as tables."""

from collections.abc import Sequence

from prp_gym.reproduction.experiment import Answer
from prp_gym.reproduction.outcome import FigureOutcome, Verdict, show, unit_of
from prp_gym.robot.arrays import Array
from prp_gym.tables import Cell, ResultTable, TableColumn
from prp_gym.tables.column import prose_column, text_column

_TONES = {"pass": "good", "explained": "warning", "FAIL": "bad"}


def verdict_table(outcomes: Sequence[FigureOutcome]) -> ResultTable:
    """Every check of some figures."""
    columns = (
        *(
            TableColumn("figure"),
            TableColumn("question"),
            text_column("quantity", 28),
            text_column("unit", 8),
        ),
        *(text_column("predicted", 17), text_column("measured", 16), text_column("tolerance", 11)),
        text_column("verdict"),
    )
    rows = [
        _check(outcome.experiment.number, verdict, first=index == 0)
        for outcome in outcomes
        for index, verdict in enumerate(outcome.verdicts)
    ]
    return ResultTable.of("predicted and measured", columns, rows)


def _check(figure: int, verdict: Verdict, first: bool) -> tuple[Cell | str, ...]:
    """One line; people see the number of the figure beside its first check alone."""
    check = verdict.check
    return (
        *(Cell(str(figure) if first else "", figure), check.question, check.what, unit_of(check)),
        *(_numbers(verdict.predicted), _numbers(verdict.measured), _numbers(verdict.tolerance, digits=2)),
        Cell(verdict.word, verdict.word, _TONES[verdict.word]),
    )


def _numbers(values: Array, digits: int = 4) -> Cell:
    """Numbers, equal ones shown once, as a text, since checks differ in how many they have."""
    text = show(values, digits)
    return Cell(text, text)


def answers_table(answers: Sequence[tuple[Answer, str]]) -> ResultTable:
    """The report's questions with their answers."""
    columns = (TableColumn("question"), prose_column("what the report asks"), prose_column("answer"))
    return ResultTable.of(
        "answers", columns, [(answer.question, answer.asks, text) for answer, text in answers]
    )
