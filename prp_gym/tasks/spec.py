"""`TaskSpec`: the declaration of a task, and the registry of tasks."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from prp_gym.registry import NOT_IN_THE_REPORT, Registry
from prp_gym.tasks.parts import TaskParts
from prp_gym.tasks.settling.criterion import SettlingCriterion
from prp_gym.tasks.setup import TaskSetup


@dataclass(frozen=True)
class NoOptions:
    """The keywords of a task that has none of its own."""


@dataclass(frozen=True)
class Criterion:
    """A quantity by which a control engineer judges an episode, and against which the reward is audited.

    It must not be one of the reward's own signals. Nothing is gained by not doing what the task asks: an
    episode that does not settle counts as the worst, as does every value beyond it.

    Attributes:
        metric: Name of a metric with one component, the smaller the better.
        worst: Largest value that counts, in the unit of the metric.
        required: Whether the reward must agree with it; else it is shown for information.
    """

    metric: str
    worst: float
    required: bool = True


@dataclass(frozen=True)
class TaskScoring:
    """How the results of policies on a task are shown and audited.

    Attributes:
        columns: Metrics whose medians are the columns of the task's tables, in their order.
        criteria: Criteria for the audit of the reward; none leave the task out of the audit.
        settling: Criterion by which the task's responses count as settled; None leaves settling undefined.
    """

    columns: tuple[str, ...] = ()
    criteria: tuple[Criterion, ...] = ()
    settling: SettlingCriterion | None = None


@dataclass(frozen=True)
class TaskEntry:
    """The code of a task.

    Attributes:
        compose: Function that makes the parts of the task; its docstring is the task's data sheet.
        options: Dataclass of the task's own keywords.
    """

    compose: Callable[[TaskSetup], TaskParts]
    options: type[Any] = NoOptions


@dataclass(frozen=True)
class TaskSpec:
    """The declaration of a task; it stands in the task's file.

    Attributes:
        id: Id for `gymnasium.make`, such as `PRP-Force-v0`.
        summary: Summary of the task in one line, for lists.
        entry: Code of the task.
        numbers: TOML file with the reward terms, the ranges of draws and the constants.
        scoring: Columns of its tables, and physical error for the audit of its reward.
        chapter: Chapter of the report, for the order of lists.
        revision: Revision of its behaviour, stored in results and agents' cards.
        released: Whether it belongs to a release, in which every task has trained agents.
    """

    id: str
    summary: str
    entry: TaskEntry
    numbers: Path
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
