"""What is compared: policies with their scores and metrics under every condition."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from prp_gym.artifacts import to_array
from prp_gym.errors import InvalidValueError
from prp_gym.robot.arrays import Array
from prp_gym.tasks.setup import MUJOCO

Record = Mapping[str, Any]

CONTROLLER, AGENT, FLOOR, VARIED = "controller", "agent", "floor", "varied"
KINDS = {
    CONTROLLER: "controller",
    AGENT: "agent",
    FLOOR: "floor",
    VARIED: "controller, other gains",
}
"""Kinds of policies with their names in tables and plots.

A controller has its tuned gains, which a search has found with as much simulated time as the training of an
agent takes; one with other gains, or an exploit of the reward, takes part in an audit alone. Floors do not
attempt the task: zero torque, and holding the start pose. Every policy has to exceed them.
"""

_RENAMED = {"zero": FLOOR}  # as results of version 0.1 call it


@dataclass(frozen=True, eq=False)
class History:
    """The score of a policy in the course of its training or tuning.

    Attributes:
        scenario: scenario in which the policy was trained or tuned.
        control_frequency: control frequency of the policy [Hz].
        steps: number of environment steps up to each point (n), increasing.
        seconds: wall time up to each point (n) [s]; NaN where it was not measured.
        score: score at each point (n) [1].
        violations: number of violations up to each point (n); NaN where they were not counted.
    """

    scenario: str
    control_frequency: float
    steps: Array
    seconds: Array
    score: Array
    violations: Array

    @classmethod
    def of(cls, plain: Record) -> Self:
        """From the history in a record."""
        names = ("steps", "seconds", "score", "violations")
        columns = {name: to_array(plain[name]) for name in names}
        return cls(plain["scenario"], float(plain["control_frequency"]), **columns)

    @property
    def simulated_seconds(self) -> Array:
        """Simulated time up to each point (n) [s]."""
        return self.steps / self.control_frequency


@dataclass(frozen=True, eq=False)
class Entry:
    """A policy under one condition: a controller, or the agents of all training seeds together.

    Attributes:
        policy: name of the policy.
        kind: kind of the policy, one of `KINDS`.
        mode: name of the action mode.
        training_seeds: training seeds, one for each row; empty for a policy that was not trained.
        scores: score of every episode, (rows, evaluation seeds) [1].
        metrics: metrics of every episode by name, (rows, evaluation seeds, components).
        compute_time: median over the rows of the compute time for one action [s].
        histories: learning histories, one for each row of a policy that was trained or tuned, else empty.
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
        """From the records of one policy under one condition, one for each training seed."""
        first = records[0]
        metrics = {
            name: np.stack([to_array(record["episodes"][name]) for record in records])
            for name in first["episodes"]
            if all(name in record["episodes"] for record in records)
        }
        return cls(
            policy=first["policy"],
            kind=_RENAMED.get(str(first["kind"]), str(first["kind"])),
            mode=first["mode"],
            training_seeds=tuple(record["training_seed"] for record in records if record["kind"] == AGENT),
            scores=metrics["score"][..., 0],
            metrics=metrics,
            compute_time=float(np.median([record["compute_time_per_step"] for record in records])),
            histories=tuple(History.of(record["history"]) for record in records if record["history"]),
        )


@dataclass(frozen=True, eq=False)
class Condition:
    """An environment in a scenario, and the policies that were evaluated there.

    Attributes:
        environment_id: id of the environment.
        scenario: name of the scenario.
        seeds: evaluation seeds, the same for all policies.
        entries: the evaluated policies.
        engine: name of the engine that simulated the episodes; MuJoCo in records that name none.
    """

    environment_id: str
    scenario: str
    seeds: tuple[int, ...]
    entries: tuple[Entry, ...]
    engine: str = MUJOCO

    @classmethod
    def of(cls, records: Sequence[Record]) -> Self:
        """From the records of one condition.

        Raises:
            InvalidValueError: policies that were evaluated on different episodes.
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
        engine = str(first.get("engine", MUJOCO))
        return cls(first["environment"], first["scenario"], tuple(first["seeds"]), entries, engine)

    def of_kind(self, *kinds: str) -> list[Entry]:
        """The policies of some kinds."""
        return [entry for entry in self.entries if entry.kind in kinds]


def group_conditions(records: Iterable[Record]) -> list[Condition]:
    """The conditions of all records, in the order of the records.

    Raises:
        InvalidValueError: policies that were evaluated on different episodes.
    """
    return [Condition.of(own) for own in _group(records, ("environment", "scenario")).values()]


def _group(records: Iterable[Record], names: tuple[str, ...]) -> dict[tuple[str, ...], list[Record]]:
    groups: dict[tuple[str, ...], list[Record]] = {}
    for record in records:
        groups.setdefault(tuple(record[name] for name in names), []).append(record)
    return groups
