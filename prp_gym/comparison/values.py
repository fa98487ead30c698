"""What is compared: policies with their scores and metrics, place by place."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from prp_gym.errors import InvalidValueError
from prp_gym.evaluation.results import to_array
from prp_gym.robot.arrays import Array

Record = Mapping[str, Any]

CONTROLLER, BUDGET, AGENT, ZERO, VARIED = "controller", "budget", "agent", "zero", "varied"
KINDS = {
    CONTROLLER: "a control law with its tuned gains",
    BUDGET: "a control law, tuned with a budget of simulated time as an agent's training has one",
    AGENT: "a learned policy",
    ZERO: "no torque at all, the control",
    VARIED: "a control law with another gain set, for the audit of the reward alone",
}
"""Kinds of policies."""

CLASSICAL = (CONTROLLER, BUDGET)


@dataclass(frozen=True, eq=False)
class History:
    """How the score of a policy grew as it was trained or tuned.

    Attributes:
        scenario: in which.
        control_frequency: actions a second [Hz].
        steps: of the environment by then (n), growing.
        seconds: of wall time by then (n) [s]; NaN where it was not measured.
        score: at that point (n) [1].
        violations: by then (n); NaN where they were not counted.
    """

    scenario: str
    control_frequency: float
    steps: Array
    seconds: Array
    score: Array
    violations: Array

    @classmethod
    def of(cls, plain: Record) -> Self:
        """From what a record holds."""
        names = ("steps", "seconds", "score", "violations")
        columns = {name: to_array(plain[name]) for name in names}
        return cls(plain["scenario"], float(plain["control_frequency"]), **columns)

    @property
    def simulated_seconds(self) -> Array:
        """Simulated time by then (n) [s]."""
        return self.steps / self.control_frequency


@dataclass(frozen=True, eq=False)
class Entry:
    """A policy at one place: a law, or the agents of all training seeds together.

    Attributes:
        policy: its name.
        kind: one of `KINDS`.
        mode: what an action means.
        training_seeds: one a row; empty where nothing was trained.
        scores: (rows, evaluation seeds) [1].
        metrics: by name, (rows, evaluation seeds, components).
        compute_time: median over the rows of the time for an action [s].
        histories: one a row where something was trained or tuned, else empty.
    """

    policy: str
    kind: str
    mode: str
    training_seeds: tuple[int, ...]
    scores: Array
    metrics: Mapping[str, Array]
    compute_time: float
    histories: tuple[History, ...]

    @classmethod
    def of(cls, records: Sequence[Record]) -> Self:
        """From the records of one policy at one place, one a training seed."""
        first = records[0]
        metrics = {
            name: np.stack([to_array(record["episodes"][name]) for record in records])
            for name in first["episodes"]
        }
        return cls(
            policy=first["policy"],
            kind=first["kind"],
            mode=first["mode"],
            training_seeds=tuple(record["training_seed"] for record in records if record["kind"] == AGENT),
            scores=metrics["score"][..., 0],
            metrics=metrics,
            compute_time=float(np.median([record["compute_time_per_step"] for record in records])),
            histories=tuple(History.of(record["history"]) for record in records if record["history"]),
        )


@dataclass(frozen=True, eq=False)
class Condition:
    """An environment in a scenario, and the policies that played it.

    Attributes:
        environment_id: of the environment.
        scenario: of the environment.
        seeds: of the episodes, the same for all.
        entries: one a policy.
    """

    environment_id: str
    scenario: str
    seeds: tuple[int, ...]
    entries: tuple[Entry, ...]

    @classmethod
    def of(cls, records: Sequence[Record]) -> Self:
        """From the records of one place.

        Raises:
            InvalidValueError: policies that did not meet the same episodes.
        """
        first = records[0]
        for record in records:
            if record["seeds"] != first["seeds"]:
                what = f"evaluation seeds of {record['policy']}"
                raise InvalidValueError(
                    what, record["seeds"], f"those of {first['policy']}, {first['seeds']}"
                )
        groups = _group(records, ("policy",))
        entries = tuple(Entry.of(own) for own in groups.values())
        return cls(first["environment"], first["scenario"], tuple(first["seeds"]), entries)

    def of_kind(self, *kinds: str) -> list[Entry]:
        """The policies of some kinds."""
        return [entry for entry in self.entries if entry.kind in kinds]


def group_conditions(records: Iterable[Record]) -> list[Condition]:
    """The places of all records, in their order.

    Raises:
        InvalidValueError: policies that did not meet the same episodes.
    """
    return [Condition.of(own) for own in _group(records, ("environment", "scenario")).values()]


def _group(records: Iterable[Record], names: tuple[str, ...]) -> dict[tuple[str, ...], list[Record]]:
    groups: dict[tuple[str, ...], list[Record]] = {}
    for record in records:
        groups.setdefault(tuple(record[name] for name in names), []).append(record)
    return groups
