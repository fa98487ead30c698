"""The experiments of the report as values: runs, panels, checks and answers, made from the data files."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from prp_gym.errors import InvalidValueError, ShapeError
from prp_gym.evaluation.rollout import Rollout
from prp_gym.reproduction.predictions import Formula
from prp_gym.robot.arrays import Array

Measure = Callable[..., Array]


@dataclass(frozen=True, eq=False)
class ExperimentRun:
    """One episode of the scenario `report` with one controller.

    Attributes:
        name: name by which figures and checks refer to the run.
        label: label of the run's curves in legends.
        environment: id of the environment.
        controller: name of the baseline.
        gains: name of the gain set.
        duration: duration of the episode [s].
        control_frequency: control frequency of the controller [Hz].
        unlimited_torque: whether the actuator limits are lifted.
        keywords: additional keywords of the environment.
        options: reset options.
        overrides: settings that replace those of the gain set; `model_masses` (3) [kg] gives the controller
            a model of the arm with other link masses.
        states: names of the arrays of the policy's state that are recorded with the fields, in their order.
        seed: random seed of the episode.
    """

    name: str
    label: str
    environment: str
    controller: str
    gains: str
    duration: float
    control_frequency: float = 1000.0
    unlimited_torque: bool = False
    keywords: Mapping[str, Any] = field(default_factory=dict)
    options: Mapping[str, Any] = field(default_factory=dict)
    overrides: Mapping[str, Any] = field(default_factory=dict)
    states: tuple[str, ...] = ()
    seed: int = 0


@dataclass(frozen=True)
class Level:
    """A horizontal line.

    Attributes:
        value: value at which the line is drawn, in the unit of the panel.
        label: label of the line in the legend.
    """

    value: float
    label: str


@dataclass(frozen=True)
class Panel:
    """Axes of a figure: one for each component of a signal.

    Attributes:
        signal: name of the signal that is drawn over time; see `prp_gym.reproduction.signals`.
        components: components of the signal, each in axes of its own.
        runs: names of the runs; the first is the subject of the figure, the others are for comparison.
        reference: signal drawn dashed, from the first run; empty for none.
        levels: lines drawn in every axes of the panel.
        predictions: names of checks of this signal, whose predictions are drawn where they belong.
        limits: limits of the vertical axis; empty to fit the curves.
    """

    signal: str
    components: tuple[int, ...]
    runs: tuple[str, ...]
    reference: str = ""
    levels: tuple[Level, ...] = ()
    predictions: tuple[str, ...] = ()
    limits: tuple[float, ...] = ()


@dataclass(frozen=True)
class Number:
    """A predicted value that does not follow from a formula of this package.

    Attributes:
        value: one number per component.
        source: source of the value.
    """

    value: tuple[float, ...]
    source: str

    @property
    def text(self) -> str:
        """Source of the value, for tables."""
        return self.source

    def compute(self) -> Array:
        """The value."""
        return np.array(self.value)


@dataclass(frozen=True, eq=False)
class Prediction:
    """A closed form with its arguments.

    Attributes:
        formula: the closed form.
        arguments: arguments of the closed form by name.
    """

    formula: Formula
    arguments: Mapping[str, Any]

    @property
    def text(self) -> str:
        """The formula and its source, for tables."""
        return f"{self.formula.text} ({self.formula.source})"

    def compute(self) -> Array:
        """The predicted value of each component."""
        return np.atleast_1d(np.asarray(self.formula.compute(**self.arguments), dtype=np.float64))


@dataclass(frozen=True, eq=False)
class Measurement:
    """A function of one recorded run.

    Attributes:
        name: name of the function.
        run: name of the run that is measured.
        function: function that measures the recorded run.
        arguments: further arguments of the function by name.
    """

    name: str
    run: str
    function: Measure
    arguments: Mapping[str, Any]

    def compute(self, rollout: Rollout) -> Array:
        """The measured value of each component."""
        return np.atleast_1d(np.asarray(self.function(rollout, **self.arguments), dtype=np.float64))


@dataclass(frozen=True, eq=False)
class Check:
    """A prediction and the measurement with which it is compared.

    Attributes:
        name: unique name, by which answers refer to the check.
        question: section of the report whose question it answers.
        what: the compared quantity, in words.
        unit: unit of the quantity, one for all components or one each.
        measure: measurement of the quantity in a run.
        predict: prediction of the quantity.
        absolute: allowed deviation, one number for all components or one each, in the unit.
        relative: further allowed deviation, as a share of the prediction.
        reason: reason for the tolerance.
        explanation: why the measurement deviates by more than the tolerance; empty if it must not.
        explained_tolerance: deviation, in the unit, up to which the explanation holds, one number for
            all components or one each; empty without an explanation.
        label: label of the prediction in the legend of a figure that draws it.
    """

    name: str
    question: str
    what: str
    unit: tuple[str, ...]
    measure: Measurement
    predict: Number | Prediction
    reason: str
    absolute: tuple[float, ...] = (0.0,)
    relative: float = 0.0
    explanation: str = ""
    explained_tolerance: tuple[float, ...] = ()
    label: str = "predicted"

    def __post_init__(self) -> None:
        if not any(self.absolute) and not self.relative:
            raise InvalidValueError(f"tolerance of check {self.name!r}", 0.0, "above 0")
        bounds = (*self.absolute, self.relative, *self.explained_tolerance)
        if not all(0.0 <= bound < math.inf for bound in bounds):
            raise InvalidValueError(f"tolerances of check {self.name!r}", bounds, "finite and at least 0")
        if bool(self.explanation) != bool(self.explained_tolerance):
            raise InvalidValueError(
                f"explained_tolerance of check {self.name!r}",
                self.explained_tolerance,
                "given if and only if an explanation is",
            )

    def require_sizes(self, predicted: Array, measured: Array) -> None:
        """Refuse numbers that cannot be compared one by one.

        Raises:
            ShapeError: another number of measured values, units or tolerances than of predictions.
        """
        size = len(predicted)
        for what, found, allowed in (
            ("measured values", len(measured), {size}),
            ("units", len(self.unit), {1, size}),
            ("absolute tolerances", len(self.absolute), {1, size}),
            ("explained tolerances", len(self.explained_tolerance), {0, 1, size}),
        ):
            if found not in allowed:
                raise ShapeError(f"{what} of check {self.name!r}", (found,), f"({size},)")

    def tolerance(self, predicted: Array) -> Array:
        """Allowed deviation from a prediction, for each component."""
        return np.broadcast_to(np.array(self.absolute), predicted.shape) + self.relative * np.abs(predicted)

    def widest_tolerance(self, predicted: Array) -> Array:
        """Deviation from a prediction that tolerance or explanation allow, for each component.

        Raises:
            InvalidValueError: an explanation that allows less than the tolerance, or nothing more.
        """
        tolerance = self.tolerance(predicted)
        if not self.explained_tolerance:
            return tolerance
        wider = np.broadcast_to(np.array(self.explained_tolerance), predicted.shape)
        if (wider < tolerance).any() or not (wider > tolerance).any():
            raise InvalidValueError(
                f"explained_tolerance of check {self.name!r}",
                self.explained_tolerance,
                f"wider than the tolerance {tolerance.tolist()}",
                ", ".join(self.unit),
            )
        return wider


@dataclass(frozen=True, eq=False)
class Experiment:
    """One figure of the report.

    Attributes:
        number: number of the figure.
        title: title of the figure.
        section: section of the report.
        until: end of the time axis [s].
        panels: panels of the figure, from top to bottom.
        checks: comparisons of predictions with measurements.
        reading: values read off the report's own figure.
        explanation: why the report's figure differs from this one; empty if it does not.
    """

    number: int
    title: str
    section: str
    until: float
    panels: tuple[Panel, ...]
    checks: tuple[Check, ...]
    reading: str
    explanation: str = ""

    @property
    def runs(self) -> tuple[str, ...]:
        """Names of the runs of the figure, each once."""
        drawn = [name for panel in self.panels for name in panel.runs]
        return tuple(dict.fromkeys(drawn + [check.measure.run for check in self.checks]))


@dataclass(frozen=True)
class Answer:
    """A one-sentence answer to a question of the report.

    Attributes:
        question: section of the report.
        asks: text of the question.
        text: text of the answer, with the names of checks as placeholders for the measured numbers.
    """

    question: str
    asks: str
    text: str
