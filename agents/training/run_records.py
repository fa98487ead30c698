"""What the files of a training run hold, as types that are checked when the files are read."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from prp_gym.agents.training.training_state import CurveRow, Violations


@dataclass(frozen=True)
class StoredBest:
    """Number and score of the best evaluation in training.

    Attributes:
        steps: number of training steps after which the policy was stored.
        score: score of the policy on the held-out episodes.
    """

    steps: int
    score: float


@dataclass(frozen=True)
class RunFacts:
    """Content of `run.json`.

    Attributes:
        command: command line that started the training.
        environment: id of the environment.
        algorithm: name of the algorithm.
        seed: training seed.
        started: date and time of the start.
        settings: settings other than the recipe, which must be the same when the run is resumed.
        versions: versions of Python and of the packages used in training.
        recipe_sha256: SHA-256 of `config.yml`; empty in a run of version 0.1.
    """

    command: str
    environment: str
    algorithm: str
    seed: int
    started: str
    settings: Mapping[str, Any]
    versions: Mapping[str, str]
    recipe_sha256: str = ""


@dataclass(frozen=True)
class RunCurve:
    """Content of `curve.json`.

    Attributes:
        unit_of_seconds: unit of the times in the rows.
        rows: evaluations, in order.
    """

    unit_of_seconds: str
    rows: tuple[CurveRow, ...]


@dataclass(frozen=True)
class RunResult:
    """Content of `result.json`.

    Attributes:
        environment: id of the environment.
        algorithm: name of the algorithm.
        action_mode: name of the action mode.
        seed: training seed.
        steps: number of training steps.
        seconds: wall-clock time of the training, including evaluations [s].
        evaluation_seconds: part of that time which evaluations took [s].
        resumes: number of times that training was resumed.
        best: best evaluation.
        last_score: score of the last evaluation.
        violations: number of violated limits in training, by the kind of limit.
    """

    environment: str
    algorithm: str
    action_mode: str
    seed: int
    steps: int
    seconds: float
    evaluation_seconds: float
    resumes: int
    best: StoredBest
    last_score: float
    violations: Mapping[str, float]


@dataclass(frozen=True)
class StoredState:
    """Content of a checkpoint's `state.json`.

    Attributes:
        counters: counters of the model by the names of its attributes.
        action_space: state of the generator of the action space.
        curve: evaluations, in order.
        violations: violated limits so far.
        seconds: wall-clock time of training so far [s].
        evaluation_seconds: part of that time which evaluations took [s].
        resumes: number of times that training was resumed.
        best: list that holds the best evaluation; empty before the first one.
        checksums: CRC-32 of the other files of the checkpoint, by their names.
    """

    counters: Mapping[str, int]
    action_space: Mapping[str, Any]
    curve: tuple[CurveRow, ...]
    violations: Violations
    seconds: float
    evaluation_seconds: float
    resumes: int
    best: tuple[StoredBest, ...]
    checksums: Mapping[str, int]
