"""`TaskSpec`: all that is to be said once about a task, and the registry of tasks."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from prp_gym.registry import NOT_IN_THE_REPORT, Registry

if TYPE_CHECKING:
    from pathlib import Path

    from prp_gym.tasks.task import TaskParts, TaskSetup


@dataclass(frozen=True)
class NoOptions:
    """The keywords of a task that has none of its own."""


@dataclass(frozen=True)
class TaskError:
    """The physical error of a task, against which its reward is audited: a sum of scaled metrics.

    Attributes:
        parts: by metric, the values of its components that count the same.
        reason: why it is this error.
    """

    parts: Mapping[str, tuple[float, ...]]
    reason: str

    @property
    def name(self) -> str:
        """For tables."""
        return " + ".join(self.parts)


@dataclass(frozen=True)
class TaskScoring:
    """How policies on a task are shown and audited.

    Attributes:
        columns: metrics whose medians stand in the tables of the task, in their order.
        error: physical error for the audit of the reward; None leaves the task out of the audit.
    """

    columns: tuple[str, ...] = ()
    error: TaskError | None = None


@dataclass(frozen=True)
class TaskEntry:
    """The code of a task.

    Attributes:
        compose: makes the parts of the task; its docstring is the task's data sheet.
        options: dataclass of the keywords of its own.
    """

    compose: "Callable[[TaskSetup], TaskParts]"
    options: type[Any] = NoOptions


@dataclass(frozen=True)
class TaskSpec:
    """The declaration of a task; it stands in the task's file.

    Attributes:
        id: for `gymnasium.make`, such as `PRP-Force-v0`.
        summary: one line for lists.
        entry: its code.
        numbers: TOML file with its reward terms, ranges of draws and constants.
        scoring: how policies on it are shown and audited.
        chapter: of the report, for the order of lists.
        revision: of its behaviour, stored in results and agents' cards.
        released: whether it belongs to a release, whose tasks all have trained agents.
    """

    id: str
    summary: str
    entry: TaskEntry
    numbers: "Path"
    scoring: TaskScoring = field(default_factory=TaskScoring)
    chapter: float = NOT_IN_THE_REPORT
    revision: int = 1
    released: bool = False

    @property
    def name(self) -> str:
        """The id."""
        return self.id


TASKS: Registry[TaskSpec] = Registry("environment", "prp_gym.envs.tasks")
"""The declared tasks by their ids."""
