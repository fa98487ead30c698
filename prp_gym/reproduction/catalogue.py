"""The experiments, read from the data files of this package; every name in them is checked."""

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import MISSING, dataclass, fields
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any, TypeVar

from prp_gym.errors import InvalidValueError, UnknownNameError
from prp_gym.files.file_reader import FileReader
from prp_gym.files.toml_text import parse_toml
from prp_gym.reproduction import contact_predictions  # noqa: F401 - registers its formulas
from prp_gym.reproduction.experiment import (
    Answer,
    Check,
    Experiment,
    ExperimentRun,
    Level,
    Measurement,
    Number,
    Panel,
    Prediction,
)
from prp_gym.reproduction.figures import COLORS, REFERENCE_LABEL
from prp_gym.reproduction.measurements import MEASUREMENTS
from prp_gym.reproduction.outcome import placeholders
from prp_gym.reproduction.predictions import FORMULAS
from prp_gym.reproduction.signals import find_signal

CHAPTERS = (
    "joint_pd.toml",
    "inverse_dynamics.toml",
    "inverse_dynamics_limits.toml",
    "adaptive.toml",
    "operational_space.toml",
    "compliance.toml",
    "impedance.toml",
    "impedance_stiff.toml",
    "admittance.toml",
    "direct_force.toml",
    "joint_transients.toml",
    "operational_transients.toml",
    "interaction_transients.toml",
    "force_transients.toml",
)

T = TypeVar("T")
Table = Mapping[str, Any]


@dataclass(frozen=True, eq=False)
class Catalogue:
    """All experiments.

    Attributes:
        runs: all runs by name.
        experiments: all experiments by figure number, in increasing order.
        answers: answers in the order of the report's questions.
    """

    runs: Mapping[str, ExperimentRun]
    experiments: Mapping[int, Experiment]
    answers: tuple[Answer, ...]

    def choose(self, numbers: Sequence[int]) -> list[Experiment]:
        """Figures by number, or all of them.

        Raises:
            UnknownNameError: a number that is not among them.
        """
        for number in numbers:
            if number not in self.experiments:
                valid = [f"{item:02d}" for item in self.experiments]
                raise UnknownNameError("figure", f"{number:02d}", valid)
        return [item for number, item in self.experiments.items() if not numbers or number in numbers]


@cache
def load_catalogue() -> Catalogue:
    """The experiments of the report.

    Raises:
        UnknownNameError: a run, signal, formula, measurement, argument or check that does not exist.
        InvalidValueError: a value that is missing or does not fit.
    """
    folder = files("prp_gym.reproduction")
    return read_catalogue([FileReader().read_text(Path(str(folder.joinpath(name)))) for name in CHAPTERS])


def read_catalogue(texts: Sequence[str]) -> Catalogue:
    """Experiments from the texts of data files; see `load_catalogue`."""
    chapters = [parse_toml(text) for text in texts]
    rows = [row for table in chapters for row in _entry(table, "runs", dict, "a chapter").items()]
    _check_unique("run", [name for name, _ in rows])
    runs = {name: _run(name, row) for name, row in rows}
    figures = [row for table in chapters for row in _tables(table, "figures")]
    later = [row for table in chapters for row in table.get("checks", [])]
    _check_known("figure", [row.get("figure") for row in later], [row.get("number") for row in figures])
    experiments = [_experiment(_extended(row, later), runs) for row in figures]
    answers = tuple(_make(Answer, row, "answer") for table in chapters for row in _tables(table, "answers"))
    _check_unique("figure", [item.number for item in experiments])
    _check_unique("check", [check.name for item in experiments for check in item.checks])
    names = {check.name for item in experiments for check in item.checks}
    for answer in answers:
        _check_known(f"check in the answer to {answer.question}", placeholders(answer.text), names)
    return Catalogue(runs, {item.number: item for item in sorted(experiments, key=_number)}, answers)


def _extended(figure: Table, later: Sequence[Table]) -> Table:
    """A figure with the checks that a chapter of transients adds to it."""
    added = [row for row in later if row["figure"] == figure.get("number")]
    own = _tables(figure, "checks", f"figure {figure.get('number')}")
    return {**figure, "checks": [*own, *({k: v for k, v in row.items() if k != "figure"} for row in added)]}


def _number(experiment: Experiment) -> int:
    return experiment.number


def _entry(table: Table, key: str, kind: type[T], what: str) -> T:
    """A required value of a given type."""
    if key not in table:
        raise InvalidValueError(f"key {key!r} of {what}", "missing", "present")
    value = table[key]
    if not isinstance(value, kind):
        raise InvalidValueError(f"key {key!r} of {what}", value, f"a {kind.__name__}")
    return value


def _tables(table: Table, key: str, what: str = "a chapter") -> list[Table]:
    """A required list of tables."""
    rows = _entry(table, key, list, what)
    for row in rows:
        if not isinstance(row, dict):
            raise InvalidValueError(f"key {key!r} of {what}", rows, "a list of tables")
    return rows


def _run(name: str, row: Any) -> ExperimentRun:
    what = f"run {name!r}"
    if not isinstance(row, dict):
        raise InvalidValueError(what, row, "a table")
    return _make(ExperimentRun, {"name": name, **_tuples(row, "states")}, what)


def _make(kind: type[T], table: Table, what: str) -> T:
    """A dataclass from a table with exactly its keys."""
    entries = {entry.name: entry for entry in fields(kind)}  # type: ignore[arg-type]
    _check_known(f"key of {what}", table, entries)
    for name, entry in entries.items():
        if entry.default is MISSING and entry.default_factory is MISSING:
            _entry(table, name, object, what)
    return kind(**table)


def _tuples(table: Table, *names: str) -> dict[str, Any]:
    """A table in which lists and single values of some names are made tuples."""
    given = {name: table[name] for name in names if name in table}
    as_tuples = {name: tuple(value) if isinstance(value, list) else (value,) for name, value in given.items()}
    return {**table, **as_tuples}


def _experiment(table: Table, runs: Mapping[str, ExperimentRun]) -> Experiment:
    what = f"figure {table.get('number')}"
    checks = tuple(_check(row, runs, what) for row in _tables(table, "checks", what))
    panels = tuple(_panel(row, runs, checks, what) for row in _tables(table, "panels", what))
    _check_drawn(
        [runs[name] for name in dict.fromkeys(name for panel in panels for name in panel.runs)], what
    )
    return _make(Experiment, {**table, "checks": checks, "panels": panels}, what)


def _check_drawn(runs: Sequence[ExperimentRun], what: str) -> None:
    """Refuse runs that cannot be drawn in one figure."""
    rates = {run.control_frequency for run in runs}
    if len(rates) > 1:
        raise InvalidValueError(f"control frequencies in {what}", sorted(rates), "one", "Hz")
    if len(runs) > len(COLORS):
        raise InvalidValueError(f"number of runs drawn in {what}", len(runs), f"at most {len(COLORS)}")
    _check_unique(f"label in {what}", [REFERENCE_LABEL, *(run.label for run in runs)])


def _panel(table: Table, runs: Mapping[str, ExperimentRun], checks: Sequence[Check], what: str) -> Panel:
    row = _tuples(table, "components", "runs", "predictions", "limits")
    row["levels"] = tuple(_make(Level, level, f"level in {what}") for level in table.get("levels", []))
    panel = _make(Panel, row, f"panel of {what}")
    for name in filter(None, (panel.signal, panel.reference)):
        _check_components(name, panel.components)
    _check_known("run", panel.runs, runs)
    of_signal = [check.name for check in checks if check.measure.arguments.get("signal") == panel.signal]
    _check_known(f"check of {panel.signal} in {what}", panel.predictions, of_signal)
    labels = [check.label for check in checks if check.name in panel.predictions]
    _check_unique(f"label of a prediction in {what}", labels)
    return panel


def _check(table: Table, runs: Mapping[str, ExperimentRun], what: str) -> Check:
    row = _tuples(table, "unit", "absolute", "explained_tolerance")
    what = f"check {table.get('name')!r} of {what}"
    row["measure"] = _measurement(dict(_entry(table, "measure", dict, what)), runs, what)
    row["predict"] = _prediction(dict(_entry(table, "predict", dict, what)), what)
    return _make(Check, row, what)


def _measurement(arguments: dict[str, Any], runs: Mapping[str, ExperimentRun], what: str) -> Measurement:
    name, run = arguments.pop("name", None), arguments.pop("run", None)
    _check_known("measurement", [name], MEASUREMENTS)
    _check_known("run", [run], runs)
    _check_components(str(arguments.get("signal")), arguments.get("components", ()))
    function = MEASUREMENTS[str(name)]
    _check_arguments(function, {"rollout": None, **arguments}, what)
    return Measurement(str(name), str(run), function, arguments)


def _prediction(arguments: dict[str, Any], what: str) -> Number | Prediction:
    if "name" not in arguments:
        return _make(Number, _tuples(arguments, "value"), f"prediction of {what}")
    name = arguments.pop("name")
    _check_known("formula", [name], FORMULAS)
    _check_arguments(FORMULAS[name].compute, arguments, what)
    return Prediction(FORMULAS[name], arguments)


def _check_arguments(function: Callable[..., Any], arguments: Table, what: str) -> None:
    signature = inspect.signature(function)
    _check_known(f"argument of {function.__name__} in {what}", arguments, signature.parameters)
    try:
        signature.bind(**arguments)
    except TypeError as error:
        raise InvalidValueError(
            f"arguments of {function.__name__} in {what}", arguments, str(error)
        ) from None


def _check_components(signal: str, components: Sequence[int]) -> None:
    known = range(len(find_signal(signal).symbols))
    _check_known(f"component of {signal}", map(str, components), [str(index) for index in known])


def _check_known(kind: str, names: Any, valid: Any) -> None:
    for name in names:
        if name not in valid:
            raise UnknownNameError(kind, name, map(str, valid))


def _check_unique(kind: str, names: Sequence[Any]) -> None:
    for name in names:
        if names.count(name) > 1:
            raise InvalidValueError(f"{kind} {name!r}", "given twice", "given once")
