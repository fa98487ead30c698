"""Results of a reproduction: the verdicts on a figure's checks, and the answers with their numbers."""

import string
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from prp_gym.reproduction.experiment import Answer, Check, Experiment
from prp_gym.reproduction.run import RecordedRun
from prp_gym.robot.arrays import Array

_NOTHING = 1e-12
_SMALL = 1e-3  # below it two digits are enough


@dataclass(frozen=True, eq=False)
class Verdict:
    """A check with its numbers.

    Attributes:
        check: the check.
        predicted: predicted value of each component.
        measured: measured value of each component.
        tolerance: allowed deviation of each component.
        widest: deviation of each component that the explanation allows; the tolerance without one.
    """

    check: Check
    predicted: Array
    measured: Array
    tolerance: Array
    widest: Array

    @property
    def word(self) -> str:
        """`pass` within the tolerance, `explained` within the bound of the explanation, else `FAIL`."""
        for word, bound in (("pass", self.tolerance), ("explained", self.widest)):
            if (np.abs(self.measured - self.predicted) <= bound).all():
                return word
        return "FAIL"


@dataclass(frozen=True, eq=False)
class FigureOutcome:
    """A figure with its recorded runs and verdicts.

    Attributes:
        experiment: the figure.
        recorded: recorded runs of the figure by name.
        verdicts: verdicts of the figure, one for each check.
    """

    experiment: Experiment
    recorded: Mapping[str, RecordedRun]
    verdicts: tuple[Verdict, ...]


def judge(experiment: Experiment, recorded: Mapping[str, RecordedRun]) -> FigureOutcome:
    """Measure the recorded runs of a figure and compare them with the predictions.

    Args:
        experiment: the figure.
        recorded: recorded runs by name, at least the figure's.

    Returns:
        the figure with its verdicts.

    Raises:
        ShapeError: numbers of a check that cannot be compared one by one.
        InvalidValueError: a measurement that a run does not allow, or an explanation that allows no
            larger deviation than the tolerance.
    """
    own = {name: recorded[name] for name in experiment.runs}
    verdicts = (judge_check(check, own[check.measure.run]) for check in experiment.checks)
    return FigureOutcome(experiment, own, tuple(verdicts))


def judge_check(check: Check, recorded: RecordedRun) -> Verdict:
    """Measure a recorded run and compare it with a check's prediction; see `judge`."""
    predicted = check.predict.compute()
    measured = check.measure.compute(recorded.rollout)
    check.require_sizes(predicted, measured)
    return Verdict(check, predicted, measured, check.tolerance(predicted), check.widest_tolerance(predicted))


def placeholders(text: str) -> set[str]:
    """Names of the checks whose numbers a template contains."""
    names = (name for _, name, _, _ in string.Formatter().parse(text) if name)
    return {name.split("[")[0] for name in names}


def fill(answers: Sequence[Answer], outcomes: Iterable[FigureOutcome]) -> list[tuple[Answer, str]]:
    """The answers whose checks were all made, with the measured numbers in place.

    Args:
        answers: templates; `{name}` is a check's first number, `{name[i]}` its i-th.
        outcomes: outcomes of the figures that were run.

    Returns:
        each answer with its sentence, in the order of the answers.
    """
    values: dict[str, Any] = {}
    for outcome in outcomes:
        values |= {verdict.check.name: _Numbers(verdict.measured) for verdict in outcome.verdicts}
    return [
        (answer, answer.text.format_map(values))
        for answer in answers
        if placeholders(answer.text) <= set(values)
    ]


class _Numbers(tuple[float, ...]):
    """Numbers of which a template formats the first unless it names another."""

    def __new__(cls, values: Array) -> "_Numbers":
        """From an array; -0 becomes 0."""
        return super().__new__(cls, (float(value) + 0.0 for value in values))

    def __format__(self, spec: str) -> str:
        return format(self[0], spec)


def unit_of(check: Check) -> str:
    """The unit of a check's numbers for tables: one, or one for each number where they differ."""
    return check.unit[0] if len(set(check.unit)) == 1 else ", ".join(check.unit)


def show(values: Array, digits: int = 4) -> str:
    """Numbers for a table, one or a list; equal ones once, rounding errors as 0."""
    texts = [_show(float(value), digits) for value in values]
    return texts[0] if len(set(texts)) == 1 else f"({', '.join(texts)})"


def _show(value: float, digits: int) -> str:
    if abs(value) < _NOTHING:
        return "0"
    return f"{value:.{digits if abs(value) >= _SMALL else 2}g}"
